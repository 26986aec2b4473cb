// The work of `raywalk-render view`: one rendered view as a picture file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/room/room.h"
#include "render/validation/view_mode.h"

namespace raywalk {

// The viewpoint of --at: "X,Z" in metres. Throws UsageError for anything else.
PlanPoint viewpoint_from_text(const std::string& text);

// Throws UsageError unless the name ends as a picture format does (.png, .jpg, .jpeg), Error unless
// a file can be made there. To be asked before the work of rendering.
void require_writable_picture(const std::filesystem::path& file);

// Where a view looks and how much of it is shown.
struct ViewFrame {
  double yaw_deg = 0.0;    // to the right
  double pitch_deg = 0.0;  // up
  double roll_deg = 0.0;   // the camera clockwise
  double fov_deg = 0.0;    // of a flat picture's width; 0: a panorama
  std::string size{};      // of a flat picture, "1440x1600"; empty: 1280x720
};

// The flat picture that a frame asks for; none where it asks for a panorama. Throws UsageError as
// require_viewport does, for a size that is none, and for a size without a field of view.
std::optional<Viewport> viewport_of(const ViewFrame& frame);

// What a view was made of, on one line: "hlf-vd, hybrid at k = 80 (...), 42 layers, ...".
std::string view_summary(const ViewMode& mode, const ViewReport& report);

// Renders the view at `viewpoint`, a panorama turned as the frame says or a flat picture, and
// writes it; returns what to tell the user, on one line. Throws Error where the room cannot be
// rendered or the picture not written; nothing is then left behind.
std::string write_view(const Room& room, const ViewMode& mode, PlanPoint viewpoint,
                       const ViewFrame& frame, const std::filesystem::path& file);

}  // namespace raywalk
