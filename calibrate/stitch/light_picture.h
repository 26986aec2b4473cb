// A reduced lens picture for measuring light.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// Light is measured as means over patches without clipped pixels.
class LightPicture {
 public:
  // Averages over `shrink` pixels (at least 1) in each direction. `picture` is CV_8UC3; `mask` is
  // CV_8UC1 of its size, 0 = masked, or empty.
  LightPicture(const cv::Mat& picture, const cv::Mat& mask, int shrink);

  // Mean levels (blue, green, red) of the patch around a position of the full picture; nullopt if
  // it reaches beyond the picture or contains pixels that are masked, too dark or too bright.
  std::optional<std::array<double, 3>> levels_at(PixelPosition full) const;

  // CV_8UC1, for tracking features.
  const cv::Mat& grey() const { return grey_; }
  PixelPosition small_from_full(PixelPosition full) const;
  PixelPosition full_from_small(PixelPosition small) const;

 private:
  cv::Size full_;
  cv::Mat levels_;  // CV_32FC3, smoothed
  cv::Mat usable_;  // CV_8UC1
  cv::Mat grey_;
};

// Radius of a patch in pixels of the reduced picture.
inline constexpr double kPatchRadius_px = 5.0;

// ln of light, up to a constant, from a mean level. A change of exposure is an affine function of
// sRGB levels (core/panorama/srgb.h), so it is the same function of their means.
double log_light(double level);

// ln(light of b / light of a) for each colour.
std::array<double, 3> log_light_ratio(const std::array<double, 3>& a,
                                      const std::array<double, 3>& b);

}  // namespace raywalk::calibrate
