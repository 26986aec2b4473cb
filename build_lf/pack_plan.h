// What a pack run is going to do, checked before any work starts: every frame and distance map is
// there with the right size, and every station has its line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {

struct PackOptions {
  std::filesystem::path frames;                    // the frame list, poses.csv
  std::filesystem::path out;                       // the room directory to make
  std::optional<std::filesystem::path> distances;  // directory of distance maps
  std::optional<double> off_line_m;                // GridTolerance::off_line_m
};

// Where a station's data come from.
struct StationSource {
  std::filesystem::path panorama;
  std::optional<Attitude> attitude;                   // turns panorama and map into world axes
  std::optional<std::filesystem::path> distance_map;  // <stem of the frame>.png
  std::optional<std::filesystem::path> mask{};        // in the frame's own axes, 0 = not to be used
  std::string where{};                                // "poses.csv:12", for errors
};

struct PackPlan {
  PanoramaSize panorama;
  PanoramaSize distance_map;  // 0 x 0 where there are no maps
  Grid grid;
  std::vector<std::vector<StationSource>> sources;  // [line][station]
  // SHA-256 over all that determines the result: the list, the options, and name, size and time of
  // every file. A run that was stopped may be resumed only by one with the same fingerprint.
  std::string fingerprint;

  bool has_maps(std::size_t line) const;
  // Bytes of all volumes together, headers not counted.
  std::uint64_t bytes() const;
};

// Throws Error: what read_frame_list and find_grid refuse, a frame that is missing or no image,
// sizes that differ, a mask that is missing, of another size or not grey, a distance directory none
// of whose maps matches a frame, a map whose size differs from the others' or exceeds the
// panorama's.
PackPlan plan_pack(const PackOptions& options);

}  // namespace raywalk::build_lf
