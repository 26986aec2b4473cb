// Settings of a virtual room. configs/virtual-room.yaml documents every key with its default.
#pragma once

#include <filesystem>
#include <string>

#include "core/files/settings.h"

namespace raywalk::capture {

// Dimensions of the room; 0: chosen by the seed.
struct RoomSettings {
  double width_m = 0.0;            // along x
  double depth_m = 0.0;            // along z
  double height_m = 0.0;           // floor to ceiling
  double camera_height_m = 0.0;    // of the lines above the floor
  double furniture_scale_m = 0.0;  // metres per room unit, at least 0.01; 0 = the cell's side

  bool operator==(const RoomSettings&) const = default;
};

struct ContentSettings {
  int chairs = 6;
  int pictures = 8;
  bool table = true;
  bool shelf = true;
  bool sofa = true;
  bool rug = true;
  bool plant = true;
  bool coat_stand = true;
  bool lamp = true;
  bool beams = true;
  bool skirting = true;
  bool mirror = true;
  bool window = true;
  bool sun_patch = true;  // needs the window
  bool wallpaper = true;
  bool plain_patch = true;

  bool operator==(const ContentSettings&) const = default;
};

// Square cells on a grid around the origin of the plan, and the stations on its lines.
struct GridSettings {
  double cell_side_m = 1.0;
  int cells_x = 1;
  int cells_z = 1;
  double spacing_mm = 0.0;       // between stations; 0 = a 40th of the cell's side
  double overhang_share = 0.25;  // captured beyond the outer corners, relative to the cell's side

  bool operator==(const GridSettings&) const = default;
};

struct SensorSettings {
  double noise_levels = 0.0;  // standard deviation of a dark pixel, in 8-bit levels
  double shot_noise = 0.0;    // added variance in squared levels, per level of brightness
  double gain_spread = 0.0;   // standard deviation of a station's exposure, relative

  bool operator==(const SensorSettings&) const = default;
};

// Standard deviations of the true poses around the nominal ones of poses.csv.
struct PoseSettings {
  double position_jitter_mm = 0.0;   // along each axis
  double attitude_jitter_deg = 0.0;  // of yaw, pitch and roll each

  bool operator==(const PoseSettings&) const = default;
};

struct OutputSettings {
  int width_px = 1024;  // of panoramas, a multiple of 4
  std::string format = "jpg";
  int jpeg_quality = 95;

  bool operator==(const OutputSettings&) const = default;
};

inline constexpr int kLeastWidth_px = 32;
inline constexpr int kLargestWidth_px = 16384;
inline constexpr double kLeastFurnitureScale_m = 0.01;
inline constexpr double kLargestFurnitureScale_m = 100.0;

struct VirtualRoomSettings {
  int seed = 1;
  GridSettings grid{};
  RoomSettings room{};
  ContentSettings contents{};
  SensorSettings sensor{};
  PoseSettings pose{};
  OutputSettings output{};

  bool operator==(const VirtualRoomSettings&) const = default;
};

// Adds the keys of a virtual room to a schema and binds them to `settings`, which must outlive it.
// `prefix` is prepended to every key, for files with other settings ("scene.").
void bind_virtual_room(SettingsSchema* schema, VirtualRoomSettings* settings,
                       const std::string& prefix);

// The same for the keys seed, room.* and contents.* only.
void bind_virtual_scene(SettingsSchema* schema, VirtualRoomSettings* settings,
                        const std::string& prefix);

// Checks beyond the ranges of single keys: throws UsageError, starting with `source`, if the width
// is not a multiple of 4.
void require_valid(const VirtualRoomSettings& settings, const std::string& source);

// Reads the file. Throws UsageError as SettingsSchema and require_valid do.
VirtualRoomSettings read_virtual_room_settings(const std::filesystem::path& file);

}  // namespace raywalk::capture
