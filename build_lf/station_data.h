// One station's data as a room stores them: in world axes, column by column.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "build_lf/pack_plan.h"
#include "core/base/error.h"

namespace raywalk {

// An input file that cannot be used, found while packing. What was packed from it so far is of no
// use: a repaired file makes it another input.
class InputError : public Error {
 public:
  using Error::Error;
};

// rays[theta][phi][rgb] of one station.
struct StationRays {
  std::vector<std::uint8_t> rays;
  std::string sha256;  // over `rays`
};

// distance_m[theta][phi] and confidence[theta][phi] of one station.
struct StationDistances {
  std::vector<float> distance_m;         // along the ray; +inf: no surface
  std::vector<std::uint8_t> confidence;  // 255: certain, as a map that is given is taken as true
  std::string sha256;                    // checksum_of_distances
};

// The checksum of one distance map: SHA-256 over the text of those of distances and of confidences.
std::string checksum_of_distances(std::span<const float> distance_m,
                                  std::span<const std::uint8_t> confidence);

// Read the station's files; throw InputError when one cannot be read or has not the size given.
StationRays read_station_rays(const StationSource& source, PanoramaSize size);
StationDistances read_station_distances(const StationSource& source, PanoramaSize size);

}  // namespace raywalk
