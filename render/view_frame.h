// Direction, field of view and size of a view, as given on the command line.
#pragma once

#include <optional>
#include <string>

#include "core/view/renderer.h"

namespace raywalk::render {

struct ViewFrame {
  double yaw_deg = 0.0;    // to the right
  double pitch_deg = 0.0;  // up
  double roll_deg = 0.0;   // the camera clockwise
  double fov_deg = 0.0;    // of a flat picture's width; 0: a panorama
  std::string size{};      // of a flat picture, "1440x1600"; empty: 1280x720
};

// The flat picture of a frame; none where the frame is a panorama. Throws UsageError as
// require_viewport does, for a malformed size, and for a size without a field of view.
std::optional<Viewport> viewport_of(const ViewFrame& frame);

// How many times wider than captured a pixel's detail is shown, in the middle of a flat picture or
// everywhere in a panorama `output_width_px` wide. Above 1 the picture shows less detail than its
// size suggests; a flat picture is enlarged more towards its borders.
double enlargement_of(const ViewFrame& frame, int output_width_px, int captured_width_px);

// "enlarged 8.8 times from panoramas 512 pixels wide"; empty where the enlargement is not above 1.
std::string enlargement_text(double enlargement, int captured_width_px);

// Renders a frame: a flat picture, or a panorama turned by resampling it. Throws UsageError as
// viewport_of() does, Error as the renderer does.
RenderedView render_framed(Renderer* renderer, PlanPoint viewpoint, const ViewFrame& frame);

}  // namespace raywalk::render
