// The data of one station as stored in a room: in world axes, column by column.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "build_lf/pack/pack_plan.h"
#include "core/room/distance_volume.h"
#include "core/room/line_volume.h"

namespace raywalk::build_lf {

// rays[theta][phi][rgb] of one station, and valid_rows[theta][2] as line_volume.h describes them;
// empty where all rows are valid.
struct StationRays {
  std::vector<std::uint8_t> rays;
  std::vector<std::int32_t> valid_rows{};
};

// distance_m[theta][phi] and confidence[theta][phi] of one station.
struct StationDistances {
  std::vector<float> distance_m;         // along the ray; +inf: no surface
  std::vector<std::uint8_t> confidence;  // 255 (certain) for given maps
  std::string sha256;                    // checksum_of_distances
};

// Checksum of a distance map: SHA-256 over the concatenated hexadecimal SHA-256 of distances and of
// confidences.
std::string checksum_of_distances(std::span<const float> distance_m,
                                  std::span<const std::uint8_t> confidence);

// Checksum of a station's rays; with valid rows, SHA-256 over the concatenated checksums of both.
std::string checksum_of_rays(std::span<const std::uint8_t> rays,
                             std::span<const std::int32_t> valid_rows);

// valid_rows[theta][2] of a mask (CV_8UC1, 0 = invalid): the longest run of valid rows in each
// column, the first of equally long ones; {0, 0} if there is none.
std::vector<std::int32_t> valid_rows_of(const cv::Mat& mask);

// As a room holds them.
StationRays stored_rays(const LineVolume& volume, int station);
StationDistances stored_distances(const DistanceVolume& volume, int map);

// Read the station's files; throw Error when one cannot be read or does not have `size`.
StationRays read_station_rays(const StationSource& source, PanoramaSize size);
StationDistances read_station_distances(const StationSource& source, PanoramaSize size);

}  // namespace raywalk::build_lf
