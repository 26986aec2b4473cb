// Settings of a capture in a virtual room. configs/virtual-room.yaml documents every key with its
// default.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "core/files/settings.h"

namespace raywalk::simulator {

struct SceneSettings {
  std::filesystem::path file = "room";  // or the name of one in configs/scenes
  Eigen::Vector3d middle_m{0, 0, 0};    // of the grid, at the height of its lines, in the scene
};

// Square cells on a grid around the origin of the plan, and the stations on its lines.
struct GridSettings {
  double cell_side_m = 1.0;
  int cells_x = 1;  // 0: a single line along z
  int cells_z = 1;
  double spacing_mm = 0.0;       // between stations; 0 = a 40th of the cell's side
  double overhang_share = 0.25;  // captured beyond the outer corners, relative to the cell's side
  bool shared_intersections = false;  // an intersection's station is of the line along x only
};

struct SensorSettings {
  double noise_levels = 0.0;  // standard deviation of a dark pixel, in 8-bit levels
  double shot_noise = 0.0;    // added variance in squared levels, per level of brightness
  double gain_spread = 0.0;   // standard deviation of a station's exposure, relative
};

// Standard deviations of the true poses around the nominal ones of poses.csv.
struct PoseSettings {
  double position_jitter_mm = 0.0;   // along each axis
  double attitude_jitter_deg = 0.0;  // of yaw, pitch and roll each
};

// The camera's exposure of the scene, also in true views.
struct LightSettings {
  double exposure = 1.0;     // multiplies all light
  double source_gain = 1.0;  // multiplies the light of sky and lamps as it is seen
  bool clip = false;         // what is brighter than white is white; else it is compressed
};

struct OutputSettings {
  int width_px = 1024;  // of panoramas, a multiple of 4
  std::string format = "jpg";
  int jpeg_quality = 95;
  std::string jpeg_colour = "full";  // "quarter": chroma at half the width and height
};

inline constexpr int kMostCells = 1000;  // along one axis
inline constexpr int kLeastWidth_px = 32;
inline constexpr int kLargestWidth_px = 16384;

struct VirtualRoomSettings {
  int seed = 1;  // of noise, jitter and the choice of true views
  SceneSettings scene{};
  GridSettings grid{};
  LightSettings light{};
  SensorSettings sensor{};
  PoseSettings pose{};
  OutputSettings output{};
};

// The schema of all keys, bound to `settings`, which must outlive it.
SettingsSchema virtual_room_schema(VirtualRoomSettings* settings);

// Adds the keys of the scene (scene.file and others), and with `prefix` before them seed and
// light.*, to a schema and binds them to `settings`, which must outlive it.
void bind_virtual_scene(SettingsSchema* schema, VirtualRoomSettings* settings,
                        const std::string& prefix);

// The scene's file in a settings file of this folder becomes relative to the current one.
void find_scene_beside(const std::filesystem::path& folder, VirtualRoomSettings* settings);

// Checks beyond the ranges of single keys: throws UsageError, starting with `source`, if the width
// is not a multiple of 4.
void require_valid(const VirtualRoomSettings& settings, const std::string& source);

// Reads the file. Throws UsageError as SettingsSchema and require_valid do.
VirtualRoomSettings read_virtual_room_settings(const std::filesystem::path& file);

}  // namespace raywalk::simulator
