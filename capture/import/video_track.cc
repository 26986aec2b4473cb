#include "capture/import/video_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"

namespace raywalk::capture {
namespace {

// Small enough to average noise, large enough for slow motion to be visible.
cv::Mat small_grey(const cv::Mat& picture) {
  constexpr int kWidth_px = 160;
  cv::Mat small;
  const int width = std::min(kWidth_px, picture.cols);
  const int height = std::max(1, picture.rows * width / picture.cols);
  cv::resize(picture, small, cv::Size(width, height), 0.0, 0.0, cv::INTER_AREA);
  cv::cvtColor(small, small, cv::COLOR_BGR2GRAY);
  return small;
}

// Of the middle half of the rows, as the upper and lower quarter of a panorama are stretched. (J.
// L. Pech-Pacheco et al., "Diatom autofocusing in brightfield microscopy", ICPR 2000.)
double sharpness_of(const cv::Mat& picture) {
  cv::Mat grey, laplacian;
  cv::cvtColor(picture.rowRange(picture.rows / 4, picture.rows - picture.rows / 4), grey,
               cv::COLOR_BGR2GRAY);
  cv::Laplacian(grey, laplacian, CV_16S);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  return deviation[0] * deviation[0];
}

}  // namespace

void read_video(const std::filesystem::path& video,
                const std::function<bool(const DecodedFrame&)>& visit) {
  if (!std::filesystem::is_regular_file(video)) {
    throw Error(fmt::format("{}: no such file", video.string()));
  }
  // Naming the backend keeps OpenCV from taking the file for an image sequence or a camera.
  // FFmpeg's own messages name no file (-8: AV_LOG_QUIET).
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  cv::VideoCapture capture;
  // Absolute, as FFmpeg takes "hall:1.mp4" for an address.
  if (!capture.open(std::filesystem::absolute(video).string(), cv::CAP_FFMPEG)) {
    throw Error(fmt::format("{}: not a video that can be read", video.string()));
  }
  const double rate_hz = capture.get(cv::CAP_PROP_FPS);
  const bool has_rate = rate_hz > 0.0 && rate_hz < 1e4;
  DecodedFrame frame{.time_s = -1.0};
  double first_s = 0.0;
  cv::Size size;
  for (; capture.read(frame.picture) && !frame.picture.empty(); ++frame.number) {
    throw_if_interrupted();
    // OpenCV documents CAP_PROP_POS_MSEC as the position of the current frame. Containers without
    // timestamps give 0 for all frames; their times follow from the frame rate.
    const double stated_s = 1e-3 * capture.get(cv::CAP_PROP_POS_MSEC);
    if (frame.number == 0) {
      first_s = stated_s;
      size = frame.picture.size();
    }
    if (frame.picture.size() != size || frame.picture.type() != CV_8UC3) {
      throw Error(fmt::format(
          "{}: frame {} is {} x {} pixels, the first {} x {}; cut the video there", video.string(),
          frame.number, frame.picture.cols, frame.picture.rows, size.width, size.height));
    }
    const bool is_stamped = stated_s - first_s > frame.time_s;
    if (!is_stamped && !has_rate) {
      throw Error(fmt::format("{}: frame {} has no timestamp, and the video has no frame rate",
                              video.string(), frame.number));
    }
    frame.time_s = is_stamped ? stated_s - first_s : frame.time_s + 1.0 / rate_hz;
    if (!visit(frame)) return;
  }
  if (frame.number == 0) throw Error(fmt::format("{}: no frame can be decoded", video.string()));
}

VideoTrack track_video(const std::filesystem::path& video) {
  VideoTrack track;
  cv::Mat before;
  read_video(video, [&](const DecodedFrame& frame) {
    cv::Mat now = small_grey(frame.picture);
    const double change = before.empty() ? 0.0 : cv::norm(before, now, cv::NORM_L1);
    track.frames.push_back(
        {frame.time_s, change / static_cast<double>(now.total()), sharpness_of(frame.picture)});
    track.size = frame.picture.size();
    before = std::move(now);
    return true;
  });
  return track;
}

std::vector<bool> blurred_frames(const VideoTrack& track) {
  // The variance halves when motion blurs edges over about two pixels.
  constexpr double kBlurredShare = 0.6;
  constexpr double kNeighbours_s = 0.5;
  const std::vector<TrackFrame>& frames = track.frames;
  std::vector<bool> blurred;
  blurred.reserve(frames.size());
  for (const TrackFrame& frame : frames) {
    const auto first =
        std::ranges::lower_bound(frames, frame.time_s - kNeighbours_s, {}, &TrackFrame::time_s);
    std::vector<double> near;
    for (auto other = first; other != frames.end() && other->time_s <= frame.time_s + kNeighbours_s;
         ++other) {
      near.push_back(other->sharpness);
    }
    blurred.push_back(frame.sharpness < kBlurredShare * median(near));
  }
  return blurred;
}

}  // namespace raywalk::capture
