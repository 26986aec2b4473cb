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
  int plain_walls = 0;  // walls of uniform colour
  bool plain_ceiling = false;
  int glass = 0;  // free-standing panes

  bool operator==(const ContentSettings&) const = default;
};

// Square cells on a grid around the origin of the plan, and the stations on its lines.
struct GridSettings {
  double cell_side_m = 1.0;
  int cells_x = 1;
  int cells_z = 1;
  double spacing_mm = 0.0;        // between stations; 0 = a 40th of the cell's side
  double overhang_share = 0.25;   // captured beyond the outer corners, relative to the cell's side
  bool shared_crossings = false;  // a crossing's station is of the line along x only

  bool operator==(const GridSettings&) const = default;
};

// A street between two rows of buildings instead of a room.
struct CanyonSettings {
  double width_m = 0.0;        // between the facades; 0: 8 to 12, chosen by the seed
  int stations = 21;           // on one line along the street
  double spacing_min_m = 0.5;  // between stations, chosen at random between the two
  double spacing_max_m = 4.0;
  int cars = 6;  // parked

  bool operator==(const CanyonSettings&) const = default;
};

// A room with rows of stands along z, between aisles.
struct HallSettings {
  int row_every = 3;  // cells along x from one row to the next
  int gap_every = 6;  // cells along z from one gap in the rows to the next

  bool operator==(const HallSettings&) const = default;
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

// The camera's exposure of the scene, also in true views.
struct LightSettings {
  double exposure = 1.0;     // multiplies all light
  double source_gain = 1.0;  // multiplies the light of sky and lamps as it is seen
  bool clip = false;         // what is brighter than white is white; else it is compressed

  bool operator==(const LightSettings&) const = default;
};

// Several cameras instead of one, on a ring around the station, stitched to a panorama.
struct RingSettings {
  int cameras = 0;  // 0: a single one in the middle
  double radius_mm = 0.0;
  double feather_deg = 0.0;          // width of the blend at a seam; 0: a hard seam
  double gain_spread = 0.0;          // standard deviation of the cameras' exposures, relative
  double station_gain_spread = 0.0;  // the same of each camera at each station
  double vignetting_share = 0.0;     // of the light, lost 90 degrees off a camera's axis

  bool operator==(const RingSettings&) const = default;
};

// People who walk around the lines during the capture.
struct PeopleSettings {
  int count = 0;
  double step_mm = 400.0;  // walked from one station to the next

  bool operator==(const PeopleSettings&) const = default;
};

struct OutputSettings {
  int width_px = 1024;  // of panoramas, a multiple of 4
  std::string format = "jpg";
  int jpeg_quality = 95;
  std::string jpeg_colour = "full";  // "quarter": chroma at half the width and height

  bool operator==(const OutputSettings&) const = default;
};

inline constexpr int kMostCells = 1000;  // along one axis
inline constexpr int kLeastWidth_px = 32;
inline constexpr int kLargestWidth_px = 16384;
inline constexpr double kLeastFurnitureScale_m = 0.01;
inline constexpr double kLargestFurnitureScale_m = 100.0;

struct VirtualRoomSettings {
  int seed = 1;
  std::string place = "room";  // or "hall", "canyon"
  GridSettings grid{};
  RoomSettings room{};
  ContentSettings contents{};
  HallSettings hall{};
  CanyonSettings canyon{};
  LightSettings light{};
  PeopleSettings people{};
  RingSettings ring{};
  SensorSettings sensor{};
  PoseSettings pose{};
  OutputSettings output{};

  bool operator==(const VirtualRoomSettings&) const = default;
};

// Adds the keys of a virtual room to a schema and binds them to `settings`, which must outlive it.
// `prefix` is prepended to every key, for files with other settings ("scene.").
void bind_virtual_room(SettingsSchema* schema, VirtualRoomSettings* settings,
                       const std::string& prefix);

// The same for the keys seed, room.*, contents.* and light.* only.
void bind_virtual_scene(SettingsSchema* schema, VirtualRoomSettings* settings,
                        const std::string& prefix);

// Checks beyond the ranges of single keys: throws UsageError, starting with `source`, if the width
// is not a multiple of 4 or keys of the ring are given without its cameras.
void require_valid(const VirtualRoomSettings& settings, const std::string& source);

// Reads the file. Throws UsageError as SettingsSchema and require_valid do.
VirtualRoomSettings read_virtual_room_settings(const std::filesystem::path& file);

}  // namespace raywalk::capture
