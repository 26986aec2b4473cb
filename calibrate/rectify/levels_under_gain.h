// Gains of linear light, applied to 8-bit levels.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

namespace raywalk::calibrate {

// Factors of linear light: red, green, blue; above 0.
using LightGain = std::array<double, 3>;

// Applies a gain of linear light to sRGB levels (0..255), clamped to 255.
class LevelsUnderGain {
 public:
  explicit LevelsUnderGain(const LightGain& gain);
  // In OpenCV's order blue, green, red.
  cv::Vec3f operator()(const cv::Vec3f& levels) const;

 private:
  static constexpr int kStepsPerLevel = 4;
  std::array<std::array<float, 255 * kStepsPerLevel + 2>, 3> table_;
};

}  // namespace raywalk::calibrate
