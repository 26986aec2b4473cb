#include "calibrate/stitch/light_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

// Sigma of a Gaussian. Pixels beyond kPatchRadius_px, which may be outside of the image circle,
// have a thousandth of the weight.
constexpr double kSmoothing_px = 1.5;
// Excludes sRGB's toe and coarsely rounded dark levels, and clipped or compressed highlights.
constexpr double kDarkest_levels = 16.0;
constexpr double kBrightest_levels = 240.0;

// 255 where no pixel of the patch is masked and no colour of it is too dark or too bright. `mask`
// was reduced like the picture.
cv::Mat usable_in(const cv::Mat& picture, const cv::Mat& mask) {
  cv::Mat in_range, usable;
  cv::inRange(picture, cv::Scalar::all(kDarkest_levels), cv::Scalar::all(kBrightest_levels),
              in_range);
  if (!mask.empty()) in_range &= mask == 255;
  const int side = 2 * static_cast<int>(kPatchRadius_px) + 1;
  cv::erode(in_range, usable, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}), {-1, -1},
            1, cv::BORDER_CONSTANT, cv::Scalar::all(0));
  return usable;
}

}  // namespace

LightPicture::LightPicture(const cv::Mat& picture, const cv::Mat& mask, int shrink)
    : full_(picture.size()) {
  const auto reduce = [&](const cv::Mat& full, cv::Mat* reduced) {
    cv::resize(full, *reduced, {std::max(1, full.cols / shrink), std::max(1, full.rows / shrink)},
               0.0, 0.0, cv::INTER_AREA);
  };
  cv::Mat small, small_mask;
  reduce(picture, &small);
  if (!mask.empty()) reduce(mask, &small_mask);
  cv::cvtColor(small, grey_, cv::COLOR_BGR2GRAY);
  usable_ = usable_in(small, small_mask);
  small.convertTo(levels_, CV_32F);
  cv::GaussianBlur(levels_, levels_, {0, 0}, kSmoothing_px);
}

PixelPosition LightPicture::small_from_full(PixelPosition full) const {
  return {(full.u + 0.5) * grey_.cols / full_.width - 0.5,
          (full.v + 0.5) * grey_.rows / full_.height - 0.5};
}

PixelPosition LightPicture::full_from_small(PixelPosition small) const {
  return {(small.u + 0.5) * full_.width / grey_.cols - 0.5,
          (small.v + 0.5) * full_.height / grey_.rows - 0.5};
}

std::optional<std::array<double, 3>> LightPicture::levels_at(PixelPosition full) const {
  const PixelPosition at = small_from_full(full);
  const int u = static_cast<int>(std::floor(at.u)), v = static_cast<int>(std::floor(at.v));
  if (u < 0 || v < 0 || u + 1 >= levels_.cols || v + 1 >= levels_.rows) return std::nullopt;
  if (usable_.at<unsigned char>(v, u) == 0) return std::nullopt;
  const auto right = static_cast<float>(at.u - u), down = static_cast<float>(at.v - v);
  const cv::Vec3f upper =
      (1.0F - right) * levels_.at<cv::Vec3f>(v, u) + right * levels_.at<cv::Vec3f>(v, u + 1);
  const cv::Vec3f lower = (1.0F - right) * levels_.at<cv::Vec3f>(v + 1, u) +
                          right * levels_.at<cv::Vec3f>(v + 1, u + 1);
  const cv::Vec3f level = (1.0F - down) * upper + down * lower;
  return std::array<double, 3>{level[0], level[1], level[2]};
}

double log_light(double level) { return kSrgbExponent * std::log(level + kSrgbShift_levels); }

std::array<double, 3> log_light_ratio(const std::array<double, 3>& a,
                                      const std::array<double, 3>& b) {
  return {log_light(b[0]) - log_light(a[0]), log_light(b[1]) - log_light(a[1]),
          log_light(b[2]) - log_light(a[2])};
}

}  // namespace raywalk::calibrate
