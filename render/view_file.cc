#include "render/view_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/number.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk {
namespace {

Attitude attitude_of(const ViewFrame& frame) {
  return {radians_from_degrees(frame.yaw_deg), radians_from_degrees(frame.pitch_deg),
          radians_from_degrees(frame.roll_deg)};
}

std::string percent(double share) {
  return share > 0.0 && share < 5e-4 ? "under 0.1 %" : fmt::format("{:.1f} %", 100.0 * share);
}

}  // namespace

PlanPoint viewpoint_from_text(const std::string& text) {
  const std::size_t comma = text.find(',');
  if (comma != std::string::npos) {
    const auto x_m = parse_finite_number(std::string_view(text).substr(0, comma));
    const auto z_m = parse_finite_number(std::string_view(text).substr(comma + 1));
    if (x_m && z_m) return {*x_m, *z_m};
  }
  throw UsageError("--at is " + excerpt(text) + "; give X,Z in metres, for example 0.1,-0.25");
}

std::optional<Viewport> viewport_of(const ViewFrame& frame) {
  Viewport viewport{.attitude = attitude_of(frame), .width = 1280, .height = 720};
  if (frame.fov_deg == 0.0) {
    if (!frame.size.empty()) {
      throw UsageError(
          "--size is that of a flat picture; give --fov-deg too, or --width for a "
          "panorama");
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

void require_writable_picture(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".png" && extension != ".jpg" && extension != ".jpeg") {
    throw UsageError("cannot write " + file.string() + ": the name must end in .png or .jpg");
  }
  const AtomicFile probe(file);
}

std::string view_summary(const ViewMode& mode, const ViewReport& report) {
  std::string text =
      fmt::format("{}, {} at k = {:g} degrees ({})", generation_name(mode.options.generation),
                  mode.connection, mode.options.k_deg, mode.k_source);
  if (report.layers > 0) text += fmt::format(", {} layers", report.layers);
  if (report.limited_corners > 0) {
    text += fmt::format(", {} of 4 corners moved for want of overhang", report.limited_corners);
  }
  if (report.filled_share > 0.0) {
    text += ", " + percent(report.filled_share) + " filled from other stations";
  }
  if (report.stretched_share > 0.0) {
    text += ", " + percent(report.stretched_share) + " seen by no station";
  }
  if (report.empty_share > 0.0) {
    text += ", " + percent(report.empty_share) + " empty: no line serves it";
  }
  return text + fmt::format(", {:.0f} ms", report.render_ms);
}

std::string write_view(const Room& room, const ViewMode& mode, PlanPoint viewpoint,
                       const ViewFrame& frame, const std::filesystem::path& file) {
  const std::optional<Viewport> viewport = viewport_of(frame);
  require_writable_picture(file);
  Renderer renderer(room, mode.options);
  const RenderedView view =
      viewport ? renderer.render(viewpoint, *viewport) : renderer.render(viewpoint);
  const Attitude turn = attitude_of(frame);
  const bool turned = turn.yaw_rad != 0.0 || turn.pitch_rad != 0.0 || turn.roll_rad != 0.0;
  write_image(file, turned && !viewport
                        ? rotate_panorama(view.image, world_from_camera(turn).transpose())
                        : view.image);
  return fmt::format("{}: {}x{} at {:g},{:g} m, {}", file.string(), view.image.cols,
                     view.image.rows, viewpoint.x_m, viewpoint.z_m,
                     view_summary(mode, view.report));
}

}  // namespace raywalk
