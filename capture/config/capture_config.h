// The configuration of a capture. configs/capture-osc.yaml explains the keys common to all
// captures, capture-gpio.yaml and capture-v4l2.yaml those of their cameras and connections. Paths
// in a file are relative to it. Units are in the names; the world frame is that of
// core/geometry/sphere.h, with its origin in the middle of the grid.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "capture/base/word_of.h"
#include "capture/camera/camera_config.h"
#include "capture/slider/slider_config.h"
#include "core/geometry/grid.h"

namespace raywalk::capture {

// A grid of square cells centred at the origin, and the stations on its lines.
struct CaptureGrid {
  double cell_side_m = 1.0;
  int cells_x = 1;
  int cells_z = 1;
  double spacing_mm = 25.0;   // between stations; whole steps must fill a cell's side
  double k_deg = 76.0;        // limit angle of the hybrid connection
  double blend_deg = 5.0;     // overlap of that connection
  double overhang_mm = -1.0;  // beyond the outer corners; -1: as k and the blend need
};

// A line that is captured as ground truth for rendered views and not packed into volumes.
struct ValidationLine {
  LineAxis axis = LineAxis::kX;
  double across_m = 0.0;  // z of a line along x, x of a line along z
  double from_m = 0.0;    // first station, along the axis
  double to_m = 0.0;      // last station
  double spacing_mm = 25.0;
};

// Distances of the scene, for checking the spacing.
struct CaptureScene {
  double nearest_m = 0.0;   // 0: unknown
  double farthest_m = 0.0;  // 0: infinitely far
  double tolerance_px = 2.0;
};

// Pictures at stations with the slider at rest, or a video of each line while it moves slowly.
enum class CaptureMode { kStations, kVideo };
inline constexpr std::array kCaptureModes{CaptureMode::kStations, CaptureMode::kVideo};

// The word of the configuration file and of the session's database: "stations" or "video".
constexpr std::string_view name_of(CaptureMode mode) {
  return word_of(mode, {"stations", "video"});
}

// How a capture is run.
struct RunConfig {
  CaptureMode mode = CaptureMode::kStations;
  double video_speed_mm_s = 20.0;
  int shots = 3;                  // tries per station before the session pauses
  double approach_mm = 5.0;       // distance below its first station at which a line starts
  double least_free_mb = 500.0;   // required on the session's disk, before and during a run
  double picture_mb = 0.0;        // expected size of one picture; 0: from width and height
  double picture_s = 0.0;         // from trigger to disk, for the estimate; 0: estimated
  double placing_s = 300.0;       // time to place the rail, for the estimate
  double work_h_per_day = 0.0;    // hours of capture on a day, for the estimate; 0: unknown
  double battery_change_s = 0.0;  // time to change the camera's battery, for the estimate
  std::string place_url;          // rigs that place their own rail get each line by HTTP POST
  double place_timeout_ms = 60000.0;
};

struct CaptureConfig {
  std::filesystem::path file{};        // the file it was read from; empty: none
  std::map<std::string, int> lines{};  // of the keys that it sets
  CaptureGrid grid{};
  std::vector<ValidationLine> validation{};
  CaptureScene scene{};
  SliderConfig slider{};
  CameraConfig camera{};
  RunConfig run{};
};

// Reads the file. Throws UsageError naming file, line and key: as SettingsSchema does, and for an
// invalid combination (limits in the wrong order).
CaptureConfig read_capture_config(const std::filesystem::path& file);

// What a plan does without. Throws UsageError as above where slider, camera or rail placement
// cannot be reached: no serial port, no register map, a gpio camera without a shutter line.
void require_devices(const CaptureConfig& config);

// To rehearse a session as planned: replaces the addresses of slider, camera and rail placement by
// those of the rig that runs in `directory` (raywalk-simulate rig). Throws UsageError: no rig runs
// there, its rig.json cannot be read, or the configured camera is not of kind osc.
void use_rig_addresses(CaptureConfig* config, const std::filesystem::path& directory);

// Throws UsageError "<file>:<line>: '<key>' <what>" for a value of the configuration; without the
// line if the file does not set it.
[[noreturn]] void refuse_setting(const CaptureConfig& config, std::string_view key,
                                 const std::string& what);

}  // namespace raywalk::capture
