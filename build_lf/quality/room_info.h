// The content of a room: `raywalk-build-lf info`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "build_lf/pack/distance_sets.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct LineInfo {
  std::string id;
  LineAxis axis = LineAxis::kX;
  int stations = 0;
  double place_m = 0.0;  // z of a line along x, x of a line along z; at its middle
  double from_m = 0.0;   // first and last station along the axis
  double to_m = 0.0;
  double oblique_deg = 0.0;  // angle to the axis
  double spacing_min_m = 0.0, spacing_median_m = 0.0, spacing_max_m = 0.0;
  // How far the stations extend beyond the outermost cell corners at the first and last end,
  // metres; negative if they do not reach them. None: no cell uses the line.
  std::optional<double> overhang_first_m, overhang_last_m;
  double masked_share = 0.0;  // of the solid angle over all stations
  int distance_maps = 0;
  PanoramaSize distance_size;  // 0 x 0 without maps
  RayForm form{};              // how its panoramas are stored
  std::uintmax_t bytes = 0;    // of the volume and the distances
};

struct RoomInfo {
  PanoramaSize panorama;
  std::vector<LineInfo> lines;
  std::vector<Cell> cells;
  int stations = 0;
  double masked_share = 0.0;          // of the solid angle of all stations
  int distance_maps = 0;              // in use
  std::string distances;              // where those in use come from: Room::distances_origin
  std::vector<FoundDistances> found;  // those that are there, or should be
  std::string compression;            // "none", "jpeg:95", "none and lossless" where lines differ
  std::string refined;                // refined_text(); empty: a captured room
  int stations_with_gains = 0;        // whose gains are not 1
  std::uintmax_t bytes = 0;  // of the manifest, the volumes, the distances and gains in use
};

RoomInfo info_of(const Room& room);

// One line: "room.lf: 4 lines, 1 cell, ...".
std::string summary_of(const RoomInfo& info, const std::string& name);
// Tables for a terminal.
std::string text_of(const RoomInfo& info, const std::string& name);
// The same as JSON; keys carry their unit.
std::string json_of(const RoomInfo& info);

}  // namespace raywalk::build_lf
