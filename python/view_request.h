// What Python asks of views: the keyword arguments of Room.view and Room.path.
#pragma once

#include <pybind11/pybind11.h>

#include "core/room/room.h"
#include "core/view/view_mode.h"
#include "render/view/measured_choice.h"
#include "render/view/presets.h"
#include "render/view/view_frame.h"
#include "render/view/view_settings.h"

namespace raywalk::python {

struct ViewRequest {
  render::ViewFlags flags{};
  render::Demand demand{};
  render::ViewFrame frame{};
};

// Keys are those of the parameters (core/view/view_options.h), of the other settings of a view
// (preset, connection, settings, budget_ms, min_psnr_db) and of ViewFrame (yaw_deg, pitch_deg,
// roll_deg, fov_deg, size_px, stereo, ipd_mm); values that are None count as not given. Throws
// TypeError for an unknown key, UsageError for values that are out of range or contradict each
// other, before any work.
ViewRequest view_request(const pybind11::dict& arguments);

// The settings of a request for a room, chosen as the programs do.
struct ChosenMode {
  ViewMode mode{};
  std::string reason{};  // of a preset or a measured choice
};
ChosenMode chosen_mode(const Room& room, const ViewRequest& request);

}  // namespace raywalk::python
