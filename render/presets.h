// Presets: settings derived from a room's own distances, spacing and width, `--preset
// fast|balanced|accurate`.
#pragma once

#include <string>

#include "core/geometry/layer_count.h"
#include "core/room/room.h"
#include "render/view_settings.h"

namespace raywalk::render {

// The numbers of a room that presets are derived from.
struct SceneNumbers {
  bool has_distances = false;
  OmegaRange scene{};  // 1st and 99th percentile over the solid angle; {0, 0} without distances
  double omega_error = 0.0;  // error of the distances, 1/m: from require.json, else one pixel of
                             // the map over the reach
  double spacing_m = 0.0;    // of the stations, median
  double reach_m = 0.0;      // half the smallest cell's side; of an open grid half its longest line
  int width_px = 0;          // of the panoramas
};

// Throws Error where the room's require.json is damaged.
SceneNumbers scene_numbers(const Room& room);

// The settings of a preset and a sentence that explains them.
struct Preset {
  ViewSettings settings{};
  std::string reason{};
  std::string k_source{};  // how settings.k_deg was chosen, where it was neither given nor auto
};

// The rules compare angles with a pixel: the vertical parallax that a view at the reach has to
// correct, and the ghost that two stations leave (core/geometry/spacing.h).
//
// fast      One bilinear sample per output pixel: initial where the whole scene moves by no more
//           than a pixel over the reach (or the room has no distances), else hlf-vd from the two
//           nearest maps. Shifts of up to half a pixel are not corrected. (Reading the nearest
//           pixel touches fewer bytes but takes no less time: finding it costs as much.)
// balanced  two-sided, bilinear, from the two nearest maps; the second side is read only where the
//           nearer one does not see the point. One station where two would show a point within half
//           a pixel of each other, else both mixed. Shifts of up to an eighth of a pixel are not
//           corrected.
// accurate  two-sided, bicubic, both sides and both stations mixed wherever they see the point.
//
// Without distances all presets give initial views. Throws UsageError for an unknown name.
Preset preset_of(const std::string& name, const SceneNumbers& scene);

// view_settings() on top of the preset that the flags or the file name, and the reason for its
// settings (empty where no preset is named). Throws as view_settings() and scene_numbers() do.
Preset preset_settings(const ViewFlags& flags, const Room& room);

}  // namespace raywalk::render
