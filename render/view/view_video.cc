#include "render/view/view_video.h"

#include <fmt/format.h>

#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "render/video/video_writer.h"
#include "render/view/view_file.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

cv::Size size_of(const Room& room, const ViewMode& mode, const ViewFrame& frame) {
  if (const auto viewport = viewport_of(frame)) return {viewport->width, viewport->height};
  const int width = mode.options.width > 0 ? mode.options.width : size_as_captured(room).width;
  return {width, frame.stereo == Stereo::kOds ? width : width / 2};
}

// None of a flat video.
std::optional<StereoMode> stereo_mode_of(const ViewFrame& frame) {
  if (viewport_of(frame)) return std::nullopt;
  return frame.stereo == Stereo::kOds ? StereoMode::kTopBottom : StereoMode::kMono;
}

std::string encode_video(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                         std::span<const PathView> views, const VideoSettings& settings,
                         const fs::path& file) {
  const cv::Size size = size_of(room, mode, frame);
  const VideoShape shape{size, std::ssize(views)};
  VideoWriter video(settings, shape, stereo_mode_of(frame), file);
  Progress progress("rendering", static_cast<std::int64_t>(views.size()), "frames");
  std::vector<PlacedFrame> frames;
  for (const PathView& view : views) frames.push_back({view.viewpoint, turned_as(view, frame)});
  render_frames(room, mode.options, frames, [&](std::size_t, const cv::Mat& image) {
    video.add(image);
    progress.advance();
  });
  video.finish();
  const int captured_px = room.panorama().width;
  const std::string enlarged =
      enlargement_text(enlargement_of(frame, size.width, captured_px), captured_px);
  const std::string eyes = stereo_text(frame);
  return fmt::format("{} frames of {}x{}, {:g} s, {}, {}{}{}", views.size(), size.width,
                     size.height, static_cast<double>(views.size()) / settings.fps,
                     codec_text(settings), viewport_of(frame) ? "flat" : "a panorama",
                     eyes.empty() ? "" : ", " + eyes, enlarged.empty() ? "" : ", " + enlarged);
}

}  // namespace

std::string write_video(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                        const PathRequest& request, const VideoSettings& settings,
                        const std::filesystem::path& file, bool replace) {
  require_video_settings(settings, file);
  require_writable_video(file, replace);
  const std::vector<PathView> views = views_of(request, room, mode, frame);
  std::string rendered;
  try {
    rendered = encode_video(room, mode, frame, views, settings, file);
  } catch (const Interrupted&) {
    throw Interrupted(
        "interrupted; an unfinished video is not kept, the same command starts it anew");
  }
  return fmt::format("{}: {}, {}, {} at k = {:g} degrees ({}), distances {}", file.string(),
                     rendered, method_name(mode.options.method), mode.connection,
                     mode.options.k_deg, mode.k_source, distances_used(room, mode));
}

}  // namespace raywalk::render
