// Presets: settings for a room, `--preset fast|balanced|accurate`.
#pragma once

#include <string>

#include "core/room/room.h"
#include "render/view/view_settings.h"

namespace raywalk::render {

// The numbers of a room that presets are derived from.
struct SceneNumbers {
  bool has_distances = false;
  double inverse_max = 0.0;  // inverse distance of the nearest surfaces, 1/m: 99th percentile over
                             // the solid angle; 0 without distances
  double reach_m = 0.0;      // half the smallest cell's side; of an open grid half its longest line
  int width_px = 0;          // of the panoramas
};

// Throws Error where the room's require.json is damaged.
SceneNumbers scene_numbers(const Room& room);

// The settings of a preset and a sentence that explains them.
struct Preset {
  ViewSettings settings{};
  std::string reason{};
  std::string k_source{};  // how settings.k_deg was chosen, where trade measured it
};

// fast      initial where the whole scene moves by no more than a pixel over the reach, else
//           hlf-vd; linear, one station of each line, from the two nearest maps. If asked to be
//           two-sided, it reads both sides only where both are about as near.
// balanced  two-sided with the defaults: linear, one station of each line, both sides wherever they
//           see the point.
// accurate  the same, cubic and with 8 stations of each line.
//
// Without distances all presets give initial views. Throws UsageError for an unknown name.
Preset preset_of(const std::string& name, const SceneNumbers& scene);

// Warns that views are initial ones where a preset or an export would correct them by distances
// that the room does not have.
void warn_without_distances(const Room& room);

// view_settings() on top of the preset that the flags or the file name, and the reason for its
// settings (empty where no preset is named). Throws as view_settings() and scene_numbers() do.
Preset preset_settings(const ViewFlags& flags, const Room& room);

}  // namespace raywalk::render
