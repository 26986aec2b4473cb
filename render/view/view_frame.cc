#include "render/view/view_frame.h"

#include <fmt/format.h>

#include <deque>
#include <future>
#include <vector>

#include "core/base/error.h"
#include "core/files/words.h"
#include "core/panorama/panorama_rotation.h"
#include "core/view/gpu/gpu_device.h"

namespace raywalk::render {
namespace {

Attitude attitude_of(const ViewFrame& frame) {
  return {radians_from_degrees(frame.yaw_deg), radians_from_degrees(frame.pitch_deg),
          radians_from_degrees(frame.roll_deg)};
}

// The eyes stand beside each other in the plan: panoramas of both can only be turned in it.
void require_stereo(const ViewFrame& frame) {
  if (frame.stereo == Stereo::kMono) {
    if (frame.ipd_mm != 0.0) {
      throw UsageError("--ipd-mm is the distance between two eyes; give --stereo ods too");
    }
    return;
  }
  if (frame.fov_deg != 0.0) {
    throw UsageError("--stereo ods is two panoramas; leave out --fov-deg for it");
  }
  if (frame.pitch_deg != 0.0 || frame.roll_deg != 0.0) {
    throw UsageError(
        "--stereo ods has its eyes beside each other at one height; pitch and roll must be 0");
  }
  const double ipd_mm = ipd_mm_of(frame);
  if (!(ipd_mm >= kLeastIpd_mm && ipd_mm <= kMostIpd_mm)) {
    throw UsageError(fmt::format("--ipd-mm is {:g}; it must be {:g} to {:g}", ipd_mm, kLeastIpd_mm,
                                 kMostIpd_mm));
  }
}

// One panorama, or two above each other, turned by resampling.
void turn_panoramas(Attitude turn, int count, cv::Mat* image) {
  if (turn.yaw_rad == 0.0 && turn.pitch_rad == 0.0 && turn.roll_rad == 0.0) return;
  const int rows = image->rows / count;
  for (int i = 0; i < count; ++i) {
    cv::Mat of_eye = image->rowRange(i * rows, (i + 1) * rows);
    // Direction d of the turned camera is R d in the world.
    rotate_panorama(of_eye.clone(), world_from_camera(turn).transpose()).copyTo(of_eye);
  }
}

}  // namespace

double ipd_mm_of(const ViewFrame& frame) {
  return frame.ipd_mm == 0.0 ? kUsualIpd_mm : frame.ipd_mm;
}

std::string stereo_text(const ViewFrame& frame) {
  if (frame.stereo == Stereo::kMono) return "";
  return fmt::format("ods, left eye above right eye, {:g} mm apart", ipd_mm_of(frame));
}

std::optional<Viewport> viewport_of(const ViewFrame& frame) {
  require_stereo(frame);
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

RenderedView render_framed(Renderer* renderer, const Viewpoint& viewpoint, const ViewFrame& frame) {
  const std::optional<Viewport> viewport = viewport_of(frame);
  if (viewport) return renderer->render(viewpoint, *viewport);
  const bool is_stereo = frame.stereo == Stereo::kOds;
  RenderedView view = is_stereo ? renderer->render_stereo(viewpoint, 1e-3 * ipd_mm_of(frame))
                                : renderer->render(viewpoint);
  turn_panoramas(attitude_of(frame), is_stereo ? 2 : 1, &view.image);
  return view;
}

void render_frames(const Room& room, const ViewOptions& options,
                   std::span<const PlacedFrame> frames,
                   const std::function<void(std::size_t, const cv::Mat&)>& use) {
  const std::size_t at_once = on_graphics_card() ? 2 : 1;
  std::deque<Renderer> renderers;
  while (renderers.size() < at_once) renderers.emplace_back(room, options);
  std::vector<std::future<cv::Mat>> rendered(at_once);
  std::future<void> used;
  const auto start = [&](std::size_t i) {
    if (i >= frames.size()) return;
    rendered[i % at_once] = std::async(std::launch::async, [&, i] {
      return render_framed(&renderers[i % at_once], frames[i].viewpoint, frames[i].frame).image;
    });
  };
  for (std::size_t i = 0; i < at_once; ++i) start(i);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const cv::Mat image = rendered[i % at_once].get();
    start(i + at_once);
    if (used.valid()) used.get();
    used = std::async(std::launch::async, [&use, i, image] { use(i, image); });
  }
  if (used.valid()) used.get();
}

}  // namespace raywalk::render
