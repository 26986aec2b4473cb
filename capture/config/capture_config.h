// What a user asks of a capture. configs/capture-osc.yaml explains every key that all captures
// have, capture-gpio.yaml and capture-v4l2.yaml those of their cameras and connections; paths in a
// file are relative to it. Units are in the names; the world frame is that of
// core/geometry/sphere.h, with its origin in the middle of the grid.
#pragma once

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "capture/camera/camera_config.h"
#include "capture/slider/slider_config.h"
#include "core/geometry/grid.h"

namespace raywalk::capture {

// Square cells on a grid around the origin of the plan, and the stations on its lines.
struct CaptureGrid {
  double cell_side_m = 1.0;
  int cells_x = 1;
  int cells_z = 1;
  double spacing_mm = 25.0;   // between stations; whole steps must fill a cell's side
  double k_deg = 76.0;        // largest incidence angle the views will use (hybrid connection)
  double blend_deg = 5.0;     // overlap of that connection
  double overhang_mm = -1.0;  // beyond the outer corners; -1: what k and the blend need
};

// A line that is captured but kept out of the volumes, as ground truth for rendered views.
struct ValidationLine {
  LineAxis axis = LineAxis::kX;
  double across_m = 0.0;  // z of a line along x, x of a line along z
  double from_m = 0.0;    // of its first and last station, along its axis
  double to_m = 0.0;
  double spacing_mm = 25.0;
};

// What the operator knows of the scene, for the spacing rule.
struct CaptureScene {
  double nearest_m = 0.0;   // 0: unknown
  double farthest_m = 0.0;  // 0: infinitely far
  double tolerance_px = 2.0;
};

// Pictures at stations where the slider stands, or a film of each line while it moves slowly.
enum class CaptureMode { kStations, kVideo };
inline constexpr std::array kCaptureModes{CaptureMode::kStations, CaptureMode::kVideo};

// The word of the configuration file and of the session's database: "stations" or "video".
constexpr std::string_view name_of(CaptureMode mode) {
  switch (mode) {
    case CaptureMode::kStations:
      return "stations";
    case CaptureMode::kVideo:
      return "video";
  }
  throw std::logic_error("unknown mode of a capture");
}

// What happens between lines, and how often a station is tried.
struct RunConfig {
  CaptureMode mode = CaptureMode::kStations;
  double video_speed_mm_s = 20.0;
  int shots = 3;                 // of one station before the session pauses
  double approach_mm = 5.0;      // below its first station, where a line is begun
  double least_free_mb = 500.0;  // on the session's disk, before and during a run
  double picture_mb = 0.0;       // expected size of one picture; 0: from width and height
  double picture_s = 0.0;        // from trigger to disk, for the estimate; 0: estimated
  double placing_s = 300.0;      // an operator's time for placing the rail, for the estimate
  std::string place_url;         // for rigs that place themselves: told each line by HTTP POST
  double place_timeout_ms = 60000.0;
};

struct CaptureConfig {
  std::filesystem::path file{};  // it was read from; empty: none
  CaptureGrid grid{};
  std::vector<ValidationLine> validation{};
  CaptureScene scene{};
  SliderConfig slider{};
  CameraConfig camera{};
  RunConfig run{};
};

// Reads the file. Throws UsageError naming file, line and key: what SettingsSchema refuses, a
// combination that cannot be (a gpio camera without a shutter line, limits the wrong way round), a
// register map that is not there.
CaptureConfig read_capture_config(const std::filesystem::path& file);

// Throws UsageError "<file>:<line>: '<key>' <what>" about a value of the configuration; without the
// line where the file does not set it.
[[noreturn]] void refuse_setting(const CaptureConfig& config, std::string_view key,
                                 const std::string& what);

}  // namespace raywalk::capture
