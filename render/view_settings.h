// Settings of a view as given on the command line or in a YAML file, before they are resolved for a
// room.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/view_mode.h"

namespace raywalk::render {

// Ranges of the settings below, wherever they come from; the least value is 1 unless stated.
inline constexpr double kMinK_deg = 45.0;
inline constexpr double kMaxK_deg = 90.0;
inline constexpr int kMaxLayers = 65536;
inline constexpr double kMinTolerance_px = 0.01;
inline constexpr double kMaxTolerance_px = 100.0;
inline constexpr double kMaxOverlap_deg = 45.0;  // from 0
inline constexpr int kMaxViewWidth_px = 32768;   // from 0
inline constexpr int kMaxStationsMixed = 2;
inline constexpr int kMaxStationStride = 1'000'000;
inline constexpr int kMaxDistanceMaps = 4;
inline constexpr int kMaxFillStations = 32;  // from 0
inline constexpr double kMaxSkip_px = 4.0;   // from 0

// Every member is a key of the YAML file (configs/view.yaml explains them one by one).
struct ViewSettings {
  // none, fast, balanced or accurate (presets.h): defaults for the other keys and flags.
  std::string preset = "none";
  std::string generation = "hlf-vd";  // initial, hlf-vd or two-sided
  std::string connection = "hybrid";  // hybrid, lfu (k = 45) or rayspace360 (k = 90)
  std::string k_deg = "auto";         // auto, or degrees in 45..90
  std::string layers = "auto";        // auto, or the number of depth layers, 1..65536
  double tolerance_px = 0.5;  // largest shift of a pixel caused by automatic layers, 0.01..100
  double overlap_deg = 5.0;   // width of the blend at a connection, 0..45
  int width_px = 0;           // 0 = as captured, else a multiple of 4 in 4..32768
  // The remaining members are as in core/view/view_options.h.
  std::string interpolation = "linear";  // nearest, linear or cubic
  std::string arithmetic = "float";      // float or double
  std::string second_side = "blend";     // blend or where-hidden
  int stations_mixed = 2;                // 1 or 2
  int station_stride = 1;                // 1..1000000
  int distance_maps = 4;                 // 1..4
  int fill_stations = 32;                // 0..32
  double skip_px = 0.0;                  // 0..4
  std::string gains = "on";              // on or off

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
  bool no_gains = false;
};

// The settings of the file, if one is given, on top of `base`, with the flags on top. Throws
// UsageError for an invalid file (as SettingsSchema does) and for values that are out of range or
// contradict each other: only the hybrid connection takes a k, the others fix it.
ViewSettings view_settings(const ViewFlags& flags, const ViewSettings& base = {});

// The settings resolved for a room: an automatic k becomes that of choose_k (core/room/choose_k.h),
// automatic layers follow the room's stored requirements (core/room/requirements.h) at each view's
// own distance from the line. Throws Error where what the room stores of these is damaged.
ViewMode view_mode(const ViewSettings& settings, const Room& room);

// The same for each of `generations`. An empty list means all generations that the room can be
// rendered in; without distances that is initial alone. Throws UsageError where one is named twice.
std::vector<ViewMode> view_modes(ViewSettings settings, std::vector<std::string> generations,
                                 const Room& room);

}  // namespace raywalk::render
