// An analytic box-shaped room with textured walls, and room directories of it, for tests of stages
// that read rooms: distance and colour of every ray are known exactly, as ground truth for views.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "core/geometry/eye_circle.h"
#include "core/geometry/grid.h"
#include "core/geometry/sphere.h"
#include "core/room/ray_form.h"

namespace raywalk {

// An axis-aligned box of the world frame, metres.
struct SceneBox {
  Eigen::Vector3d min_m{0, 0, 0};
  Eigen::Vector3d max_m{0, 0, 0};
};

struct SyntheticScene {
  // The room; cameras must be inside it.
  SceneBox walls{{-2.5, -1.2, -2.2}, {2.4, 1.5, 2.6}};
  // An occluding object in the room; cameras must be outside it.
  std::optional<SceneBox> obstacle{};
  // Renders a sky instead: all distances are infinite, and the picture is the same from everywhere.
  bool infinitely_far = false;
  // The texture is a sum of waves of about this wavelength, determined by the seed.
  double texture_wavelength_m = 1.0;
  // 1: grey levels 38 to 218. 0: uniform grey, 128.
  double contrast = 1.0;
  unsigned seed = 1;
  // Added to the seed for the obstacle, so that its edges are visible.
  unsigned obstacle_seed_step = 1;
};

// Distance along the ray from `origin_m` to the first surface in metres; +inf if the scene is
// infinitely far. `direction` is a unit vector.
double distance_at(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                   const Eigen::Vector3d& direction);

// Colour (red, green, blue) along the ray, 0..255, not rounded.
Eigen::Vector3d color_at(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                         const Eigen::Vector3d& direction);

// The panorama (BGR, CV_8UC3, width / 2 rows) of an eye, sampled at pixel centres. Colours are
// multiplied by `gain`, which simulates a different exposure.
cv::Mat render_scene(const SyntheticScene& scene, const EyeCircle& eye, int width,
                     double gain = 1.0);
// The same from one place.
cv::Mat render_scene(const SyntheticScene& scene, const Eigen::Vector3d& origin_m, int width,
                     double gain = 1.0);

// An object in front of the camera: dolly or operator in every frame, or a visitor in some.
struct CameraCompanion {
  // Whether it hides a direction (unit vector) at a station of a line.
  std::function<bool(const std::string& line, int station, const Eigen::Vector3d& direction)> hides;
  Eigen::Vector3d color{255, 0, 255};  // red, green, blue
  // Whether masks are written: in each column only the rows above it are valid.
  bool masked = true;
  // Whether its pixels are recorded as left out of views, beside the distances.
  bool left_out = false;
};

// How far a station is off its line.
struct OffLine {
  double across_m = 0.0;  // towards +z from a line along x, +x from a line along z
  double up_m = 0.0;
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
  // Moves stations off their lines; empty: all are on them.
  std::function<OffLine(const std::string& line, int station)> off_line{};
  int width = 128;         // of the panoramas, even
  bool distances = true;   // with exact distance maps
  int distance_every = 1;  // at every n-th station, starting at the first
  int distance_width = 0;  // of the maps, even; 0 = as the panoramas
  // Value stored in the maps at pixel (u, v), whose true distance is exact_m; empty: exact_m.
  std::function<float(int u, int v, double exact_m)> stored_distance{};
  // Confidence stored there; empty: 255.
  std::function<std::uint8_t(int u, int v)> stored_confidence{};
  std::map<std::string, double> line_gain{};  // exposure of a line by its id; others have 1
  std::optional<CameraCompanion> companion{};
  RayForm form{};         // how rays are stored
  int tile_columns = 16;  // of compressed ones
};

// The grid of such a room.
Grid synthetic_grid(const SyntheticRoomSpec& spec);

// Writes a complete room for Room::open. Creates the directory; existing files are replaced.
void write_synthetic_room(const SyntheticRoomSpec& spec, const std::filesystem::path& room);

// Takes away the distances of a line.
void remove_distances(const std::filesystem::path& room, const std::string& line);

// The ground truth view (BGR, CV_8UC3) at a viewpoint, at the height of the lines and with gain 1.
cv::Mat render_truth(const SyntheticRoomSpec& spec, PlanPoint viewpoint, int width);

}  // namespace raywalk
