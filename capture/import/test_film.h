// For tests: a pass of the carriage along a line, its journal, and a film shot from it.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "capture/session/session.h"

namespace raywalk::capture {

// From rest to rest at constant acceleration and speed.
struct TestPass {
  double start_s = 0.0;  // when it begins to move
  double from_mm = 0.0;
  double to_mm = 400.0;
  double speed_mm_s = 40.0;
  double acceleration_mm_s2 = 100.0;

  double end_s() const {
    return start_s + (to_mm - from_mm) / speed_mm_s + speed_mm_s / acceleration_mm_s2;
  }
  double position_mm(double time_s) const {
    const double ramp_s = speed_mm_s / acceleration_mm_s2;
    const double since_s = std::clamp(time_s - start_s, 0.0, end_s() - start_s);
    const double left_s = end_s() - start_s - since_s;
    if (since_s < ramp_s) return from_mm + 0.5 * acceleration_mm_s2 * since_s * since_s;
    if (left_s < ramp_s) return to_mm - 0.5 * acceleration_mm_s2 * left_s * left_s;
    return from_mm + speed_mm_s * (since_s - 0.5 * ramp_s);
  }
  // Samples every 20 ms until 0.3 s after the end.
  std::vector<JournalSample> journal(WallTime epoch) const {
    std::vector<JournalSample> samples;
    for (double time_s = start_s; time_s < end_s() + 0.3; time_s += 0.02) {
      const Duration since{std::llround(time_s * 1e9)};
      samples.push_back(
          {epoch + std::chrono::duration_cast<WallTime::duration>(since), position_mm(time_s)});
    }
    return samples;
  }
};

// A scene that shifts as the carriage moves, one pixel per millimetre, with sensor noise.
class TestScene {
 public:
  explicit TestScene(cv::Size size) : size_(size), random_(17) {
    cv::Mat noise(size.height, 8 * size.width, CV_8UC3);
    random_.fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(noise, surrounding_, cv::Size(0, 0), 1.5);
    cv::normalize(surrounding_, surrounding_, 0, 255, cv::NORM_MINMAX);
  }

  cv::Mat picture(double position_mm) {
    const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, -position_mm, 0, 1, 0);
    cv::Mat seen;
    cv::warpAffine(surrounding_, seen, shift, size_, cv::INTER_LINEAR, cv::BORDER_WRAP);
    cv::Mat noise(size_, CV_16SC3);
    random_.fill(noise, cv::RNG::NORMAL, 0, 2);
    cv::add(seen, noise, seen, cv::noArray(), CV_8UC3);
    return seen;
  }

 private:
  cv::Size size_;
  cv::Mat surrounding_;
  cv::RNG random_;
};

struct TestFilm {
  double rate_hz = 25.0;
  double start_s = 0.0;  // when its first frame is exposed
  double length_s = 0.0;
  cv::Size size{160, 80};
  std::function<bool(double position_mm)> blurred{};
};

// Shoots a film (MJPG in AVI) of a carriage that is at `position_mm(time)`.
inline void shoot_test_film(const std::filesystem::path& file, const TestFilm& film,
                            const std::function<double(double time_s)>& position_mm) {
  cv::VideoWriter writer(file.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), film.rate_hz,
                         film.size);
  TestScene scene(film.size);
  const auto frames = static_cast<std::size_t>(film.length_s * film.rate_hz);
  for (std::size_t i = 0; i < frames; ++i) {
    const double time_s = film.start_s + static_cast<double>(i) / film.rate_hz;
    const double along_mm = position_mm(time_s);
    cv::Mat picture = scene.picture(along_mm);
    if (film.blurred && film.blurred(along_mm)) cv::blur(picture, picture, cv::Size(9, 1));
    writer.write(picture);
  }
}

}  // namespace raywalk::capture
