#include "render/view_frame.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/number.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::render {
namespace {

Attitude attitude_of(const ViewFrame& frame) {
  return {radians_from_degrees(frame.yaw_deg), radians_from_degrees(frame.pitch_deg),
          radians_from_degrees(frame.roll_deg)};
}

}  // namespace

std::optional<Viewport> viewport_of(const ViewFrame& frame) {
  Viewport viewport{.attitude = attitude_of(frame), .width = 1280, .height = 720};
  if (frame.fov_deg == 0.0) {
    if (!frame.size.empty()) {
      throw UsageError(
          "--size is for a flat picture; give --fov-deg too, or use --width for a panorama");
    }
    require_viewport(viewport);
    return std::nullopt;
  }
  viewport.fov_x_rad = radians_from_degrees(frame.fov_deg);
  if (!frame.size.empty()) {
    const std::size_t by = frame.size.find('x');
    const auto width = parse_whole_number(std::string_view(frame.size).substr(0, by));
    const auto height = by == std::string::npos
                            ? std::nullopt
                            : parse_whole_number(std::string_view(frame.size).substr(by + 1));
    if (!width || !height) {
      throw UsageError("--size is " + excerpt(frame.size) +
                       "; give WIDTHxHEIGHT in pixels, for example 1440x1600");
    }
    viewport.width = *width;
    viewport.height = *height;
  }
  require_viewport(viewport);
  return viewport;
}

double enlargement_of(const ViewFrame& frame, int output_width_px, int captured_width_px) {
  const std::optional<Viewport> viewport = viewport_of(frame);
  const double px_per_rad = viewport ? focal_length_px(*viewport) : output_width_px / kTwoPi;
  return px_per_rad * kTwoPi / captured_width_px;
}

std::string enlargement_text(double enlargement, int captured_width_px) {
  constexpr double kVisible = 1.01;
  if (enlargement < kVisible) return "";
  return fmt::format("enlarged {:.{}f} times from panoramas {} pixels wide", enlargement,
                     enlargement < 10.0 ? 1 : 0, captured_width_px);
}

RenderedView render_framed(Renderer* renderer, PlanPoint viewpoint, const ViewFrame& frame) {
  const std::optional<Viewport> viewport = viewport_of(frame);
  if (viewport) return renderer->render(viewpoint, *viewport);
  RenderedView view = renderer->render(viewpoint);
  const Attitude turn = attitude_of(frame);
  if (turn.yaw_rad != 0.0 || turn.pitch_rad != 0.0 || turn.roll_rad != 0.0) {
    // Direction d of the turned camera is R d in the world.
    view.image = rotate_panorama(view.image, world_from_camera(turn).transpose());
  }
  return view;
}

}  // namespace raywalk::render
