// Settings of a view as given on the command line or in a YAML file, before they are resolved for a
// room.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/room/room.h"
#include "core/view/view_mode.h"

namespace raywalk::render {

inline constexpr std::array<std::string_view, 3> kPresets{"fast", "balanced", "accurate"};
inline constexpr std::array<std::string_view, 3> kConnections{"hybrid", "lfu", "rayspace360"};

// The keys of the YAML file are `preset`, `connection` and those of the parameters
// (kViewParameters), which configs/view.yaml explains one by one.
struct ViewSettings {
  // none, fast, balanced or accurate (presets.h): defaults for the other keys and flags.
  std::string preset = "none";
  std::string connection = "hybrid";  // hybrid, lfu (k = 45) or rayspace360 (k = 90)
  ViewOptions options = default_options();

  friend bool operator==(const ViewSettings&, const ViewSettings&) = default;
};

// The flags of a command line, which override the file's keys.
struct ViewFlags {
  std::optional<std::filesystem::path> settings{};
  std::optional<std::string> preset{};
  std::optional<std::string> connection{};
  std::map<std::string, std::string> parameters{};  // as written, by the parameter's key
};

// The settings of the file, if one is given, on top of `base`, with the flags on top. Throws
// UsageError for an invalid file (as SettingsSchema does) and for values that are out of range or
// contradict each other: only the hybrid connection takes a k, the others fix it.
ViewSettings view_settings(const ViewFlags& flags, const ViewSettings& base = {});

// The settings with the k of their connection.
ViewMode view_mode(const ViewSettings& settings);

// The same for each of `methods`. An empty list means all methods that the room can be
// rendered in; without distances that is initial alone. Throws UsageError where one is named twice.
std::vector<ViewMode> view_modes(ViewSettings settings, std::vector<std::string> methods,
                                 const Room& room);

}  // namespace raywalk::render
