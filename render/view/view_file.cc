#include "render/view/view_file.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/view/view_plan.h"
#include "render/view/point_argument.h"
#include "render/view/write_picture.h"

namespace raywalk::render {
namespace {

std::string percent(double share) {
  return share > 0.0 && share < 5e-4 ? "under 0.1 %" : fmt::format("{:.1f} %", 100.0 * share);
}

// "0.1,-0.25", or "0.1,0.05,-0.25" with a height.
std::string text_of(const Viewpoint& viewpoint) {
  const std::string height = viewpoint.height_m ? fmt::format("{:g},", *viewpoint.height_m) : "";
  return fmt::format("{:g},{}{:g}", viewpoint.plan.x_m, height, viewpoint.plan.z_m);
}

}  // namespace

Viewpoint viewpoint_from_text(const std::string& text) {
  const std::vector<double> numbers = parse_point(text);
  if (numbers.size() == 2) return {numbers[0], numbers[1]};
  if (numbers.size() == 3) return {{numbers[0], numbers[2]}, numbers[1]};
  throw UsageError("--at is " + excerpt(text) +
                   "; give X,Z or X,Y,Z in metres, for example 0.1,-0.25");
}

void require_writable_picture(const std::filesystem::path& file) { const AtomicFile probe(file); }

void require_writable_view(const std::filesystem::path& file) {
  require_writable_picture(file);
  if (!std::filesystem::is_regular_file(file)) return;
  const std::string bytes = read_file(file);
  if (bytes.empty() || bytes.find("Raywalk") != std::string::npos) return;
  throw Error(file.string() + " exists and is no view made by Raywalk; choose another --out");
}

std::string distances_used(const Room& room, const ViewMode& mode) {
  return mode.options.method == ViewMethod::kInitial ? "none" : room.distances_origin();
}

ConnectionRule connection_rule(const ViewMode& mode) {
  return {radians_from_degrees(mode.options.k_deg), radians_from_degrees(mode.options.overlap_deg)};
}

ViewDescription describe_view(const Room& room, const ViewMode& mode, const Viewpoint& viewpoint,
                              const ViewFrame& frame) {
  const ViewPlan plan(room.grid(), viewpoint, connection_rule(mode));
  return {
      .x_m = viewpoint.plan.x_m, .y_m = plan.height_m(), .z_m = viewpoint.plan.z_m, .frame = frame};
}

std::string view_summary(const ViewMode& mode, const ViewReport& report) {
  std::string text =
      fmt::format("{}, {} at k = {:g} degrees ({})", method_name(mode.options.method),
                  mode.connection, mode.options.k_deg, mode.k_source);
  if (report.limited_corners > 0) {
    text +=
        fmt::format(", {} of 4 corners moved because the overhang ran out", report.limited_corners);
  }
  if (report.filled_share > 0.0) {
    text += ", " + percent(report.filled_share) + " filled from other stations";
  }
  if (report.unseen_share > 0.0) {
    text += ", " + percent(report.unseen_share) + " seen by no station";
  }
  if (report.empty_share > 0.0) {
    text += ", " + percent(report.empty_share) + " empty: no line serves it";
  }
  return text + fmt::format(", {:.0f} ms", report.render_ms);
}

std::string write_view(const Room& room, const ViewMode& mode, const Viewpoint& viewpoint,
                       const ViewFrame& frame, const std::filesystem::path& file,
                       const PictureFormat& format) {
  viewport_of(frame);  // rejects an invalid frame before any work
  require_writable_view(file);
  Renderer renderer(room, mode.options);
  const RenderedView view = render_framed(&renderer, viewpoint, frame);
  write_picture(file, view.image, format, describe_view(room, mode, viewpoint, frame));
  const int captured_px = room.panorama().width;
  const std::string enlarged =
      enlargement_text(enlargement_of(frame, view.image.cols, captured_px), captured_px);
  const std::string eyes = stereo_text(frame);
  return fmt::format("{}: {}x{}{}{} at {} m, distances {}, {}", file.string(), view.image.cols,
                     view.image.rows, eyes.empty() ? "" : ", " + eyes + ",",
                     enlarged.empty() ? "" : ", " + enlarged + ",", text_of(viewpoint),
                     distances_used(room, mode), view_summary(mode, view.report));
}

}  // namespace raywalk::render
