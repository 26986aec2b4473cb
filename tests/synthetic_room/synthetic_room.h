// Room directories of a scene in closed form, for the tests of the stages that read rooms.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "core/geometry/grid.h"
#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk {

// What every camera has in its view that is not part of the scene: its dolly, its operator.
struct CameraCompanion {
  // Whether it hides this direction (a unit vector) from a station of a line.
  std::function<bool(const std::string& line, int station, const Eigen::Vector3d& direction)> hides;
  Eigen::Vector3d color{255, 0, 255};  // red, green, blue
  // With masks: of every column of a frame that it is in, what lies above it is valid.
  bool masked = true;
};

// A grid of cells_x x cells_z square cells around the origin of the plan: cells_z + 1 lines along
// x ("x0" at the back) and cells_x + 1 along z ("z0" at the left). With cells_z = 0 there is a
// single line, "x0" through the origin, and no cell.
struct SyntheticRoomSpec {
  SyntheticScene scene{};
  int cells_x = 1;
  int cells_z = 1;
  double side_m = 1.0;       // N
  double spacing_m = 0.125;  // between stations; rounded so that whole steps fill a line
  double overhang_m = 0.0;   // how far every line is captured beyond the outer corners
  double height_m = 0.0;     // y of all stations
  int width = 128;           // of the panoramas, even
  bool distances = true;     // with exact distance maps
  int distance_every = 1;    // at every so many-th station, from the first on
  int distance_width = 0;    // of the maps, even; 0 = as the panoramas
  // What the maps hold in the pixel (u, v) where the room is exact_m away; empty: that.
  std::function<float(int u, int v, double exact_m)> stored_distance{};
  std::map<std::string, double> line_gain{};  // exposure of a line by its id; others have 1
  std::optional<CameraCompanion> companion{};
};

// The grid of such a room.
Grid synthetic_grid(const SyntheticRoomSpec& spec);

// Writes a complete room as Room::open reads it. The directory is made; what is in it is replaced.
void write_synthetic_room(const SyntheticRoomSpec& spec, const std::filesystem::path& room);

// The exact view (BGR, CV_8UC3) at a viewpoint, at the height of the lines and with gain 1.
cv::Mat render_truth(const SyntheticRoomSpec& spec, PlanPoint viewpoint, int width);

}  // namespace raywalk
