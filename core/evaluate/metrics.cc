#include "core/evaluate/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

constexpr int kChannels = 3;
constexpr double kPeak = 255.0;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string size_text(const cv::Mat& image) { return fmt::format("{}x{}", image.cols, image.rows); }

double counted_pixels(const cv::Mat& image, const cv::Mat& mask) {
  return static_cast<double>(mask.empty() ? image.total() : cv::countNonZero(mask));
}

void require_comparable(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  require_image_pair(a, b, 1);
  if (mask.empty()) return;
  if (mask.type() != CV_8UC1 || mask.size() != a.size()) {
    throw Error("cannot compare images: the mask must be 8-bit, one channel, of the images' size");
  }
  if (cv::countNonZero(mask) == 0) {
    throw Error("cannot compare images: the mask selects no pixel; give one that does");
  }
}

constexpr int kStep = 4;                // pixels between blocks of SSIM
constexpr int kBlock = 2 * kStep;       // pixels
constexpr double kN = kBlock * kBlock;  // samples of a block

// ffmpeg holds both constants as integers, scaled like the sums they are added to, C1 by 64 and C2
// by 64 * 63: 6.5025 * 64 = 416.16 and 58.5225 * 64 * 63 = 235962.72, rounded. The sums that C1 is
// added to are products of two block sums and so carry 64^2; hence the effective C1 of metrics.h.
constexpr double kScaledC1 = 416.0;
constexpr double kScaledC2 = 235963.0;

// Over the blocks; exact for integers.
cv::Mat block_sums(const cv::Mat& values) {
  cv::Mat at_every_pixel, sums;
  cv::boxFilter(values, at_every_pixel, CV_64F, {kBlock, kBlock}, {0, 0}, false);
  const cv::Size blocks(values.cols / kStep - 1, values.rows / kStep - 1);
  const cv::Rect counted(0, 0, blocks.width * kStep, blocks.height * kStep);
  cv::resize(at_every_pixel(counted), sums, blocks, 0.0, 0.0, cv::INTER_NEAREST);
  return sums;
}

cv::Mat rounded_luma(const cv::Mat& bgr) {
  cv::Mat rounded, luma;
  cv::cvtColor(bgr, rounded, cv::COLOR_BGR2GRAY);
  rounded.convertTo(luma, CV_64F);
  return luma;
}

constexpr int kReach_px = 2;
constexpr double kNoSurface_mm = 65535.0;

// With columns of the other side of the seam on both sides.
cv::Mat with_seam(const cv::Mat& image, int columns) {
  cv::Mat wider;
  cv::copyMakeBorder(image, wider, 0, 0, columns, columns, cv::BORDER_WRAP);
  return wider;
}

cv::Mat median_3x3(const cv::Mat& image) {
  cv::Mat median;
  cv::medianBlur(with_seam(image, 1), median, 3);
  return median.colRange(1, 1 + image.cols);
}

// Over the channels.
cv::Mat largest_difference(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  std::array<cv::Mat, 3> channels;
  cv::split(difference, channels.data());
  return cv::max(channels[0], cv::max(channels[1], channels[2]));
}

cv::Mat specks(const cv::Mat& view, const cv::Mat& truth) {
  return (largest_difference(view, median_3x3(view)) > 32) &
         (largest_difference(truth, median_3x3(truth)) < 16) &
         (largest_difference(view, truth) > 48);
}

double psnr_within(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask) {
  return cv::countNonZero(mask) == 0 ? kNan : std::min(psnr_db(view, truth, mask), kMaxPsnrDb);
}

}  // namespace

void require_image_pair(const cv::Mat& a, const cv::Mat& b, int min_side) {
  for (const cv::Mat* image : {&a, &b}) {
    if (image->dims != 2 || image->empty()) {
      throw Error("cannot compare images: one of them is empty; give two 8-bit colour images");
    }
    if (image->type() != CV_8UC3) {
      throw Error(
          fmt::format("cannot compare images: type is {}; give 8-bit colour images with 3 channels",
                      cv::typeToString(image->type())));
    }
  }
  if (a.size() != b.size()) {
    throw Error(fmt::format(
        "cannot compare images of different sizes, {} and {}; give both at the same size",
        size_text(a), size_text(b)));
  }
  if (std::min(a.cols, a.rows) < min_side) {
    throw Error(fmt::format("cannot compare images of {}; this metric needs at least {}x{}",
                            size_text(a), min_side, min_side));
  }
}

double psnr_db(double mean_squared_error) {
  if (mean_squared_error == 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(kPeak * kPeak / mean_squared_error);
}

double mean_squared_error(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  require_comparable(a, b, mask);
  return cv::norm(a, b, cv::NORM_L2SQR, mask) / (counted_pixels(a, mask) * kChannels);
}

double psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  return psnr_db(mean_squared_error(a, b, mask));
}

double ws_psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  require_comparable(a, b, mask);
  double weighted_error = 0.0, weight_sum = 0.0;
  for (int row = 0; row < a.rows; ++row) {
    const cv::Mat counted = mask.empty() ? mask : mask.row(row);
    const PixelPosition pixel{0.0, static_cast<double>(row)};
    const double weight = std::cos(angles_from_pixel(pixel, {a.cols, a.rows}).phi_rad);
    weighted_error += weight * cv::norm(a.row(row), b.row(row), cv::NORM_L2SQR, counted);
    weight_sum += weight * counted_pixels(a.row(row), counted);
  }
  return psnr_db(weighted_error / (weight_sum * kChannels));
}

// The formula of metrics.h with its fractions cleared: means times N = 64, variances times
// N (N - 1), N (N - 1) v = N sum x^2 - (sum x)^2. Only the sum of both variances is needed.
double ssim(const cv::Mat& a, const cv::Mat& b) {
  require_image_pair(a, b, kBlock);
  const cv::Mat luma_a = rounded_luma(a), luma_b = rounded_luma(b);
  const cv::Mat sum_a = block_sums(luma_a), sum_b = block_sums(luma_b);
  const cv::Mat squares = sum_a.mul(sum_a) + sum_b.mul(sum_b), product = sum_a.mul(sum_b);
  const cv::Mat variances = kN * block_sums(luma_a.mul(luma_a) + luma_b.mul(luma_b)) - squares;
  const cv::Mat covariance = kN * block_sums(luma_a.mul(luma_b)) - product;
  const cv::Mat above = (2.0 * product + kScaledC1).mul(2.0 * covariance + kScaledC2);
  const cv::Mat below = (squares + kScaledC1).mul(variances + kScaledC2);
  return cv::mean(above / below)[0];
}

cv::Mat near_silhouettes(const cv::Mat& distances_mm) {
  if (distances_mm.empty() || distances_mm.type() != CV_16UC1) {
    throw Error("silhouettes need distances of 16 bits in one channel");
  }
  cv::Mat distance;
  with_seam(distances_mm, kReach_px + 1).convertTo(distance, CV_32F);
  distance.setTo(kNoSurface_mm, distance == 0.0);
  const cv::Mat neighbours = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
  cv::Mat farthest, nearest;
  cv::dilate(distance, farthest, neighbours);
  cv::erode(distance, nearest, neighbours);
  // 1.15 = 23 / 20, exact in whole numbers.
  const cv::Mat own_20 = 20.0 * distance, own_23 = 23.0 * distance;
  const cv::Mat silhouettes = (20.0 * farthest > own_23) | (own_20 > 23.0 * nearest);
  constexpr int kSide_px = 2 * kReach_px + 1;
  cv::Mat near;
  cv::dilate(silhouettes, near, cv::Mat::ones(kSide_px, kSide_px, CV_8UC1));
  return near.colRange(kReach_px + 1, kReach_px + 1 + distances_mm.cols).clone();
}

SilhouetteScores score_silhouettes(const cv::Mat& view, const cv::Mat& truth,
                                   const cv::Mat& distances_mm, const cv::Mat& mask) {
  require_image_pair(view, truth, 1);
  if (distances_mm.size() != truth.size()) {
    throw Error("silhouettes need distances of the size of the images");
  }
  const cv::Mat near = near_silhouettes(distances_mm);
  cv::Mat counted = cv::Mat(truth.size(), CV_8UC1, cv::Scalar(255));
  if (!mask.empty()) counted = mask != 0;
  const cv::Mat counted_near = near & counted, counted_elsewhere = counted & ~near;
  const double pixels = cv::countNonZero(counted);
  if (pixels == 0.0) throw Error("cannot measure silhouettes: the mask selects no pixel");
  return {.near_psnr_db = psnr_within(view, truth, counted_near),
          .elsewhere_psnr_db = psnr_within(view, truth, counted_elsewhere),
          .near_share = cv::countNonZero(counted_near) / pixels,
          .specks_per_mpx = 1e6 * cv::countNonZero(specks(view, truth) & counted) / pixels};
}

}  // namespace raywalk
