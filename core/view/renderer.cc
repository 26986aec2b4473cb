#include "core/view/renderer.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/view/flat_view.h"
#include "core/view/gpu/gpu_device.h"
#include "core/view/gpu/gpu_renderer.h"
#include "core/view/picture_fill.h"
#include "core/view/prepared_view.h"

namespace raywalk {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

PanoramaPart whole(PanoramaSize size) {
  return {.first_column = 0, .columns = size.width, .rows = {0, size.height}};
}

void report_counts(const PixelCounts& counts, ViewReport* report) {
  const auto share = [&](std::int64_t pixels) {
    return static_cast<double>(pixels) / static_cast<double>(counts.all);
  };
  report->filled_share = share(counts.filled);
  report->unseen_share = share(counts.unseen);
  report->empty_share = share(counts.empty);
}

}  // namespace

PanoramaSize size_as_captured(const Room& room) {
  constexpr int kWidthStep = 4;
  const int width = room.panorama().width / kWidthStep * kWidthStep;
  return {width, width / 2};
}

void require_viewpoint(const Viewpoint& viewpoint, ViewMethod method) {
  const double height_m = viewpoint.height_m.value_or(0.0);
  if (!std::isfinite(viewpoint.plan.x_m) || !std::isfinite(viewpoint.plan.z_m) ||
      !std::isfinite(height_m)) {
    throw UsageError("the viewpoint must be finite numbers in metres");
  }
  if (viewpoint.height_m && method == ViewMethod::kInitial) {
    throw UsageError(
        "initial views do not know distances and cannot be moved up or down; leave the height out, "
        "or use --method hlf-vd or two-sided");
  }
}

Viewpoint viewpoint_for(ViewMethod method, PlanPoint plan, std::optional<double> height_m) {
  return method == ViewMethod::kInitial ? Viewpoint(plan) : Viewpoint(plan, height_m);
}

Renderer::Renderer(const Room& room, const ViewOptions& options) : room_(room), options_(options) {
  if (options_.width == 0) options_.width = size_as_captured(room).width;
  require_view_options(options_);
  if (options.method != ViewMethod::kInitial && !room_.has_distances()) {
    throw Error(fmt::format(
        "{}: the room has no distances, which {} needs; estimate them with raywalk-build-lf depth, "
        "give them to raywalk-build-lf pack --distance DIR, or use --method initial",
        room_.directory().string(), method_name(options.method)));
  }
  if (options_.gains && !room_.gains().empty()) exposure_ = std::make_unique<Exposure>(room_);
  try {
    gpu_ = make_gpu_renderer(room_, options_.gains);
  } catch (const GpuError& error) {
    warn_of_gpu(error.what());
  }
  // A panorama much smaller than the captured ones is rendered larger and averaged down, so that
  // fine texture does not alias.
  supersampling_ = std::max(
      1,
      static_cast<int>(std::lround(static_cast<double>(room.panorama().width) / options_.width)));
  const int width = options_.width * supersampling_;
  for (auto* eye : {&eye_, &right_eye_}) {
    *eye = std::make_unique<PreparedView>(room_, options_, exposure_.get(),
                                          PanoramaSize{width, width / 2});
  }
}

Renderer::~Renderer() = default;

PreparedView& Renderer::prepare(const Viewpoint& viewpoint) {
  require_viewpoint(viewpoint, options_.method);
  eye_->prepare(viewpoint);
  return *eye_;
}

RenderedView Renderer::render(const Viewpoint& viewpoint, RenderedView view) {
  const auto start = Clock::now();
  render_eyes(std::array{&prepare(viewpoint)}, &view);
  view.report.render_ms = ms_since(start);
  return view;
}

RenderedView Renderer::render_stereo(const Viewpoint& viewpoint, double eyes_apart_m,
                                     RenderedView view) {
  const auto start = Clock::now();
  require_viewpoint(viewpoint, options_.method);
  PreparedView::prepare_stereo(viewpoint, eyes_apart_m, eye_.get(), right_eye_.get());
  render_eyes(std::array{eye_.get(), right_eye_.get()}, &view);
  view.report.render_ms = ms_since(start);
  return view;
}

void Renderer::render_eyes(std::span<PreparedView* const> eyes, RenderedView* view) {
  const PanoramaSize size = eyes.front()->output();
  const auto count = static_cast<int>(eyes.size());
  cv::Mat& rendered = supersampling_ > 1 ? oversized_ : view->image;
  for (PreparedView* eye : eyes) eye->look_at(whole(size));
  PixelCounts counts;
  cv::Mat1b unread;
  PreparedView::render(eyes, whole(size), gpu_.get(), nullptr, &rendered, &unread, &counts);
  for (int eye = 0; eye < count && !unread.empty(); ++eye) {
    const cv::Range rows(eye * size.height, (eye + 1) * size.height);
    cv::Mat of_eye = rendered.rowRange(rows);
    fill_picture(unread.rowRange(rows), Seam::kJoined, {0, size.height}, &of_eye);
  }
  report_counts(counts, &view->report);
  view->report.limited_corners = eyes.front()->plan().limited_corners();
  if (supersampling_ == 1) return;
  cv::resize(rendered, view->image, cv::Size(options_.width, count * options_.width / 2), 0, 0,
             cv::INTER_AREA);
}

RenderedView Renderer::render(const Viewpoint& viewpoint, const Viewport& viewport,
                              RenderedView view) {
  require_viewport(viewport);
  const auto start = Clock::now();
  prepare(viewpoint);
  const PanoramaSize panorama = eye_->output();
  const int fold = flat_supersampling(viewport, panorama);
  Viewport fine = viewport;
  fine.width *= fold;
  fine.height *= fold;
  PanoramaPart part = part_shown(fine, panorama);
  PixelCounts counts;
  cv::Mat1b unread;
  const auto render = [&](const FlatPicture* flat) {
    counts = {};
    return PreparedView::render(std::array{eye_.get()}, part, gpu_.get(), flat, &part_, &unread,
                                &counts);
  };
  const auto seam = [&] { return part.columns == panorama.width ? Seam::kJoined : Seam::kOpen; };
  const auto rows = [&] { return ShownRows{part.rows.begin, panorama.height}; };
  cv::Mat& resampled = fold > 1 ? oversized_ : view.image;
  eye_->look_at(part);
  const FlatPicture flat{fine, &resampled};
  if (!render(&flat)) {
    // What surrounds a large unread place may lie beyond the part: then it is filled as in the
    // panorama, so that it looks the same from every direction.
    if (!unread.empty() && is_unread_at_border(unread, seam(), rows(), panorama.width / 64)) {
      part = whole(panorama);
      eye_->look_at(part);
      render(nullptr);
    }
    if (!unread.empty()) fill_picture(unread, seam(), rows(), &part_);
    resample_flat(part_, part, panorama, fine, options_.interpolation, &resampled);
  }
  if (fold > 1) {
    cv::resize(resampled, view.image, cv::Size(viewport.width, viewport.height), 0, 0,
               cv::INTER_AREA);
  }
  report_counts(counts, &view.report);
  view.report.limited_corners = eye_->plan().limited_corners();
  view.report.render_ms = ms_since(start);
  return view;
}

}  // namespace raywalk
