// Ready-made settings: `--preset fast|balanced|accurate`, rules over a room's own numbers.
#pragma once

#include <string>

#include "core/geometry/layer_count.h"
#include "core/room/room.h"
#include "render/view_settings.h"

namespace raywalk::render {

// What the rules go by.
struct SceneNumbers {
  bool has_distances = false;
  OmegaRange scene{};        // of 1 and 99 % of the solid angle; {0, 0} without distances
  double omega_error = 0.0;  // of the distances, 1/m: that of require.json, else one pixel of them
                             // over the reach
  double spacing_m = 0.0;    // of the stations, median
  double reach_m = 0.0;      // half the smallest cell's side; of an open grid half its longest line
  int width_px = 0;          // of the panoramas
};

// Throws Error where the room's require.json is damaged.
SceneNumbers scene_numbers(const Room& room);

// The settings of a preset, and why, in words.
struct Preset {
  ViewSettings settings{};
  std::string reason{};
};

// In all of them what shows is decided by angles: of the vertical parallax that a view from the
// reach has to correct, of the ghost that two stations leave (core/geometry/spacing.h), of the
// error of float arithmetic.
//
// fast      One bilinear sample per output pixel: initial where the whole scene moves by no more
//           than a pixel over the reach (or no distances are known), else hlf-vd, by the two
//           nearest maps. Shifts of up to half a pixel are not corrected. (Reading the nearest
//           pixel touches fewer bytes but takes no less time: finding it costs as much.)
// balanced  two-sided, bilinear, by the two nearest maps, the second side read only where the
//           nearer one does not see; one station where two would show a point within half a pixel
//           of each other, else both mixed. Shifts of up to an eighth of a pixel are not corrected.
// accurate  two-sided, bicubic, both sides and both stations mixed wherever they see the point;
//           double precision where float would place a sample wrong by 1/64 pixel.
//
// Without distances all are initial views. Throws UsageError for another name.
Preset preset_of(const std::string& name, const SceneNumbers& scene);

// view_settings() on top of the preset that flags or file name, and why it is as it is (empty:
// none is named). Throws as view_settings() and scene_numbers() do.
Preset preset_settings(const ViewFlags& flags, const Room& room);

}  // namespace raywalk::render
