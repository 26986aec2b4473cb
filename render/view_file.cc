#include "render/view_file.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/command_line/point_argument.h"
#include "core/files/atomic_output.h"
#include "core/view/view_plan.h"
#include "render/picture/write_picture.h"

namespace raywalk::render {
namespace {

std::string percent(double share) {
  return share > 0.0 && share < 5e-4 ? "under 0.1 %" : fmt::format("{:.1f} %", 100.0 * share);
}

// The work that skip_px skipped in a corrected view.
std::string skipped_work(const WorkCounts& work, std::int64_t pixels) {
  const auto share = [](std::int64_t part, std::int64_t all) {
    return percent(all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0);
  };
  return fmt::format(", skipped: {} of corrections, {} of second stations, {} of second sides",
                     share(work.uncorrected, work.readings), share(work.one_station, work.readings),
                     share(work.one_side, pixels));
}

}  // namespace

PlanPoint viewpoint_from_text(const std::string& text) {
  if (const auto pair = parse_coordinate_pair(text)) return {pair->first, pair->second};
  throw UsageError("--at is " + excerpt(text) + "; give X,Z in metres, for example 0.1,-0.25");
}

void require_writable_picture(const std::filesystem::path& file) { const AtomicFile probe(file); }

std::string distances_used(const Room& room, const ViewMode& mode) {
  return mode.options.generation == Generation::kInitial ? "none" : room.distances_origin();
}

ConnectionRule connection_rule(const ViewMode& mode) {
  return {radians_from_degrees(mode.options.k_deg), radians_from_degrees(mode.options.overlap_deg)};
}

ViewDescription describe_view(const Room& room, const ViewMode& mode, PlanPoint viewpoint,
                              const ViewFrame& frame) {
  const ViewPlan plan(room.grid(), viewpoint, connection_rule(mode));
  return {.x_m = viewpoint.x_m, .y_m = plan.height_m(), .z_m = viewpoint.z_m, .frame = frame};
}

std::string view_summary(const ViewMode& mode, const ViewReport& report) {
  std::string text =
      fmt::format("{}, {} at k = {:g} degrees ({})", generation_name(mode.options.generation),
                  mode.connection, mode.options.k_deg, mode.k_source);
  if (report.layers > 0) text += fmt::format(", {} layers", report.layers);
  if (report.limited_corners > 0) {
    text +=
        fmt::format(", {} of 4 corners moved because the overhang ran out", report.limited_corners);
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
  if (mode.options.skip_px > 0.0 && mode.options.generation != Generation::kInitial) {
    text += skipped_work(report.work, report.pixels);
  }
  return text + fmt::format(", {:.0f} ms", report.render_ms);
}

std::string write_view(const Room& room, const ViewMode& mode, PlanPoint viewpoint,
                       const ViewFrame& frame, const std::filesystem::path& file,
                       const PictureFormat& format) {
  viewport_of(frame);  // rejects an invalid frame before any work
  require_writable_picture(file);
  Renderer renderer(room, mode.options);
  const RenderedView view = render_framed(&renderer, viewpoint, frame);
  write_picture(file, view.image, format, describe_view(room, mode, viewpoint, frame));
  const int captured_px = room.panorama().width;
  const std::string enlarged =
      enlargement_text(enlargement_of(frame, view.image.cols, captured_px), captured_px);
  return fmt::format("{}: {}x{}{} at {:g},{:g} m, distances {}, {}", file.string(), view.image.cols,
                     view.image.rows, enlarged.empty() ? "" : ", " + enlarged + ",", viewpoint.x_m,
                     viewpoint.z_m, distances_used(room, mode), view_summary(mode, view.report));
}

}  // namespace raywalk::render
