#include "build_lf/refine/sharpening.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/panorama/transposed_border.h"

namespace raywalk::build_lf {
namespace {

constexpr int kBorder = 16;  // pixels, more than the filters reach

// By half a captured pixel.
cv::Mat blurred(const cv::Mat& picture, int captured_width, int width) {
  const double sigma_px = 0.5 * width / captured_width;
  cv::Mat result;
  cv::GaussianBlur(picture, result, {}, sigma_px);
  return result;
}

// What views of the captured width show of it on average: bilinear samples at places all over the
// pixels, averaged over a pixel of the view.
cv::Mat as_views_show(const cv::Mat& picture, PanoramaSize captured) {
  const cv::Mat kernel = (cv::Mat1f(1, 3) << 1.0f / 6.0f, 2.0f / 3.0f, 1.0f / 6.0f);
  cv::Mat sampled, shown;
  cv::sepFilter2D(picture, sampled, -1, kernel, kernel);
  cv::resize(without_border(sampled, kBorder), shown, {captured.height, captured.width}, 0.0, 0.0,
             cv::INTER_AREA);
  return shown;
}

}  // namespace

double measured_sharpening(const cv::Mat& others, const cv::Mat& photograph,
                           const cv::Mat1b& comparable) {
  constexpr float kContradicts = 25.0f;  // levels: not a matter of sharpness
  constexpr double kSteepest = 60.0;     // degrees of latitude: beyond, columns are oversampled
  constexpr int kFewest = 1000;          // pixels
  const PanoramaSize captured{photograph.rows, photograph.cols};
  cv::Mat levels, known;
  others.convertTo(levels, CV_32F, 1.0 / kLevel);
  cv::inRange(others, cv::Scalar::all(0), cv::Scalar::all(0), known);
  // Where all pixels that the filters reach are known.
  cv::dilate(with_border(known, kBorder), known, cv::Mat::ones(9, 9, CV_8U));
  cv::resize(without_border(known, kBorder), known, {captured.height, captured.width}, 0.0, 0.0,
             cv::INTER_AREA);
  const cv::Mat picture = with_border(levels, kBorder);
  const cv::Mat shown = as_views_show(picture, captured);
  const cv::Mat detail =
      as_views_show(picture - blurred(picture, captured.width, others.rows), captured);
  const auto first = static_cast<int>(captured.height * (0.5 - kSteepest / 180.0));
  double missing = 0.0, there = 0.0;
  int count = 0;
  for (int theta = 0; theta < captured.width; ++theta) {
    for (int phi = first; phi < captured.height - first; ++phi) {
      if (known.at<std::uint8_t>(theta, phi) != 0 || comparable(theta, phi) == 0) continue;
      const cv::Vec3f off =
          cv::Vec3f(photograph.at<cv::Vec3b>(theta, phi)) - shown.at<cv::Vec3f>(theta, phi);
      if (std::max({std::fabs(off[0]), std::fabs(off[1]), std::fabs(off[2])}) > kContradicts) {
        continue;
      }
      const auto& fine = detail.at<cv::Vec3f>(theta, phi);
      missing += off.dot(fine);
      there += fine.dot(fine);
      ++count;
    }
  }
  if (count < kFewest || there <= 0.0) return 1.0;
  return std::clamp(missing / there, 0.0, 2.0);
}

cv::Mat sharpened(const cv::Mat& colour, int captured_width, double amount) {
  cv::Mat levels, result;
  colour.convertTo(levels, CV_32F, 1.0 / kLevel);
  const cv::Mat picture = with_border(levels, kBorder);
  const cv::Mat blur = blurred(picture, captured_width, colour.rows);
  without_border((1.0 + amount) * picture - amount * blur, kBorder).convertTo(result, CV_8U);
  return result;
}

}  // namespace raywalk::build_lf
