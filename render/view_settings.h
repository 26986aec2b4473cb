// What a user asks of a view, on the command line or in a YAML file, before it is known which room
// it meets.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "render/validation/view_mode.h"

namespace raywalk::render {

// Every member is a key of the YAML file (configs/view.yaml explains them one by one).
struct ViewSettings {
  // none, fast, balanced or accurate (presets.h): what other keys and flags do not say.
  std::string preset = "none";
  std::string generation = "hlf-vd";  // initial, hlf-vd or two-sided
  std::string connection = "hybrid";  // hybrid, lfu (k = 45) or rayspace360 (k = 90)
  std::string k_deg = "auto";         // auto, or degrees in 45..90
  std::string layers = "auto";        // auto, or how many depth layers, 1..65536
  double tolerance_px = 0.5;          // move of a pixel that automatic layers may cause, 0.01..100
  double overlap_deg = 5.0;           // width of the blend at a connection, 0..45
  int width_px = 0;                   // 0 = as captured, else a multiple of 4 in 4..32768
  // The others are as in render/view/view_options.h.
  std::string interpolation = "linear";  // nearest, linear or cubic
  std::string arithmetic = "float";      // float or double
  std::string second_side = "blend";     // blend or where-hidden
  int stations_mixed = 2;                // 1 or 2
  int station_stride = 1;                // 1..1000000
  int distance_maps = 4;                 // 1..4
  int fill_stations = 32;                // 0..32
  double skip_px = 0.0;                  // 0..4

  friend bool operator==(const ViewSettings&, const ViewSettings&) = default;
};

// The flags of a command line, which override the file's keys.
struct ViewFlags {
  std::optional<std::filesystem::path> settings{};
  std::optional<std::string> preset{};
  std::optional<std::string> generation{};
  std::optional<std::string> connection{};
  std::optional<std::string> k_deg{};
  std::optional<std::string> layers{};
  std::optional<double> tolerance_px{};
  std::optional<double> overlap_deg{};
  std::optional<int> width_px{};
  std::optional<std::string> interpolation{};
  std::optional<std::string> arithmetic{};
  std::optional<std::string> second_side{};
  std::optional<int> stations_mixed{};
  std::optional<int> station_stride{};
  std::optional<int> distance_maps{};
  std::optional<int> fill_stations{};
  std::optional<double> skip_px{};
};

// The settings of the file, if one is given, on top of `base`, with the flags on top. Throws
// UsageError for a file that is not right (as SettingsSchema does) and for values that are out of
// range or contradict each other: k belongs to the hybrid connection, the others have theirs.
ViewSettings view_settings(const ViewFlags& flags, const ViewSettings& base = {});

// The settings for a room, where "auto" becomes a number: by what the room keeps of its
// requirements (core/room/requirements.h), for layers at each view's own distance from the line.
// Throws Error where what it keeps is damaged.
ViewMode view_mode(const ViewSettings& settings, const Room& room);

// The same in each of `generations`; in all that the room can be rendered in where none is named:
// without distances that is initial alone. Throws UsageError where one is named twice.
std::vector<ViewMode> view_modes(ViewSettings settings, std::vector<std::string> generations,
                                 const Room& room);

}  // namespace raywalk::render
