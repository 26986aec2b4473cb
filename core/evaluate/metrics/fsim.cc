#include "core/evaluate/metrics/fsim.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/evaluate/metrics/image_pair.h"
#include "core/evaluate/metrics/luma.h"
#include "core/evaluate/metrics/phase_congruency.h"

namespace raywalk {
namespace {

constexpr int kMinSide_px = 8;
constexpr double kWorkingSide_px = 256.0;
constexpr double kT1 = 0.85;   // for phase congruency, which is within [0, 1]
constexpr double kT2 = 160.0;  // for gradients in 8-bit levels per pixel

// The panorama with `border` pixels around it: columns wrap, the top and bottom row repeat.
cv::Mat with_border(const cv::Mat& image, int border) {
  cv::Mat wide;
  cv::copyMakeBorder(image, wide, 0, 0, border, border, cv::BORDER_WRAP);
  cv::Mat framed;
  cv::copyMakeBorder(wide, framed, border, border, 0, 0, cv::BORDER_REPLICATE);
  return framed;
}

// Means of factor x factor pixels around every factor-th pixel, from the first on. For an even
// factor the window cannot be centred; it reaches one pixel further to the right and down, so that
// a factor of 2 averages disjoint squares.
cv::Mat reduced(const cv::Mat& image, int factor) {
  if (factor == 1) return image;
  const int before = (factor - 1) / 2;
  cv::Mat means;
  cv::boxFilter(with_border(image, factor), means, CV_64F, cv::Size(factor, factor),
                cv::Point(before, before));
  cv::Mat out((image.rows + factor - 1) / factor, (image.cols + factor - 1) / factor, CV_64FC1);
  for (int row = 0; row < out.rows; ++row) {
    for (int col = 0; col < out.cols; ++col) {
      out.at<double>(row, col) = means.at<double>((row + 1) * factor, (col + 1) * factor);
    }
  }
  return out;
}

// Magnitude of the Scharr gradient, in levels per two pixels as the paper's kernels (weights 3, 10,
// 3 over 16) give it.
cv::Mat gradient_magnitude(const cv::Mat& image) {
  const cv::Mat framed = with_border(image, 1);
  const cv::Rect inside(1, 1, image.cols, image.rows);
  cv::Mat along_x;
  cv::Mat along_y;
  cv::Scharr(framed, along_x, CV_64F, 1, 0, 1.0 / 16.0);
  cv::Scharr(framed, along_y, CV_64F, 0, 1, 1.0 / 16.0);
  cv::Mat magnitude;
  cv::magnitude(along_x(inside), along_y(inside), magnitude);
  return magnitude;
}

double similarity(double a, double b, double constant) {
  return (2.0 * a * b + constant) / (a * a + b * b + constant);
}

double pooled_similarity(const cv::Mat& congruency_a, const cv::Mat& congruency_b,
                         const cv::Mat& gradient_a, const cv::Mat& gradient_b) {
  double sum = 0.0;
  double weight_sum = 0.0;
  for (int row = 0; row < congruency_a.rows; ++row) {
    for (int col = 0; col < congruency_a.cols; ++col) {
      const double pa = congruency_a.at<double>(row, col);
      const double pb = congruency_b.at<double>(row, col);
      const double gradients =
          similarity(gradient_a.at<double>(row, col), gradient_b.at<double>(row, col), kT2);
      const double weight = std::max(pa, pb);
      sum += similarity(pa, pb, kT1) * gradients * weight;
      weight_sum += weight;
    }
  }
  return weight_sum > 0.0 ? sum / weight_sum : 1.0;
}

}  // namespace

double fsim(const cv::Mat& a, const cv::Mat& b) {
  require_image_pair(a, b, kMinSide_px);
  const int factor =
      std::max(1, static_cast<int>(std::lround(std::min(a.rows, a.cols) / kWorkingSide_px)));
  const cv::Mat luma_a = reduced(luma_unrounded(a), factor);
  const cv::Mat luma_b = reduced(luma_unrounded(b), factor);
  const PhaseCongruency congruency(luma_a.size());
  return pooled_similarity(congruency(luma_a), congruency(luma_b), gradient_magnitude(luma_a),
                           gradient_magnitude(luma_b));
}

}  // namespace raywalk
