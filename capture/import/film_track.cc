#include "capture/import/film_track.h"

#include <algorithm>
#include <cstddef>
#include <opencv2/imgproc.hpp>

#include "capture/import/video_reader.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"

namespace raywalk::capture {
namespace {

// Small enough to average noise, large enough for slow motion to be visible.
constexpr int kSmallWidth_px = 160;
// A frame below this share of its neighbours' median sharpness counts as blurred. The variance
// halves when motion blurs edges over about two pixels.
constexpr double kBlurredShare = 0.6;
constexpr double kNeighbours_s = 0.5;

cv::Mat small_grey(const cv::Mat& picture) {
  cv::Mat small;
  const int width = std::min(kSmallWidth_px, picture.cols);
  const int height = std::max(1, picture.rows * width / picture.cols);
  cv::resize(picture, small, cv::Size(width, height), 0.0, 0.0, cv::INTER_AREA);
  cv::cvtColor(small, small, cv::COLOR_BGR2GRAY);
  return small;
}

double typical_sharpness(const FilmTrack& track, std::size_t of) {
  const double time_s = track.frames[of].time_s;
  std::vector<double> near;
  for (std::size_t i = of; i-- > 0 && track.frames[i].time_s >= time_s - kNeighbours_s;) {
    near.push_back(track.frames[i].sharpness);
  }
  for (std::size_t i = of;
       i < track.frames.size() && track.frames[i].time_s <= time_s + kNeighbours_s; ++i) {
    near.push_back(track.frames[i].sharpness);
  }
  return median(near);
}

}  // namespace

double activity_between(const cv::Mat& small_before, const cv::Mat& small_now) {
  return cv::norm(small_before, small_now, cv::NORM_L1) / static_cast<double>(small_now.total());
}

double sharpness_of(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture.rowRange(picture.rows / 4, picture.rows - picture.rows / 4), grey,
               cv::COLOR_BGR2GRAY);
  cv::Mat laplacian;
  cv::Laplacian(grey, laplacian, CV_16S);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  return deviation[0] * deviation[0];
}

FilmTrack track_film(const std::filesystem::path& film) {
  VideoReader reader(film);
  FilmTrack track;
  DecodedFrame frame;
  cv::Mat before;
  while (reader.next(&frame)) {
    throw_if_interrupted();
    cv::Mat now = small_grey(frame.picture);
    const double activity = before.empty() ? 0.0 : activity_between(before, now);
    track.frames.push_back({frame.time_s, activity, sharpness_of(frame.picture)});
    track.size = frame.picture.size();
    before = std::move(now);
  }
  return track;
}

std::vector<bool> blurred_frames(const FilmTrack& track) {
  std::vector<bool> blurred(track.frames.size());
  for (std::size_t i = 0; i < blurred.size(); ++i) {
    blurred[i] = track.frames[i].sharpness < kBlurredShare * typical_sharpness(track, i);
  }
  return blurred;
}

}  // namespace raywalk::capture
