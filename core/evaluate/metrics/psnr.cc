#include "core/evaluate/metrics/psnr.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/evaluate/metrics/image_pair.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

constexpr int kChannels = 3;
constexpr double kPeak = 255.0;

std::int64_t squared_difference(const std::uint8_t* a, const std::uint8_t* b) {
  const int difference = int{*a} - int{*b};
  return std::int64_t{difference} * difference;
}

// Of the pixels of a row that count.
struct RowError {
  std::int64_t sum = 0;  // of squared differences; exact: 2^31 samples stay below 2^47
  std::int64_t pixels = 0;
};

RowError row_error(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask, int row) {
  const std::uint8_t* row_a = a.ptr(row);
  const std::uint8_t* row_b = b.ptr(row);
  RowError error;
  if (mask.empty()) {
    for (int i = 0; i < kChannels * a.cols; ++i) {
      error.sum += squared_difference(row_a + i, row_b + i);
    }
    error.pixels = a.cols;
    return error;
  }
  const std::uint8_t* selected = mask.ptr(row);
  for (int col = 0; col < a.cols; ++col) {
    if (selected[col] == 0) continue;
    ++error.pixels;
    for (int i = kChannels * col; i < kChannels * (col + 1); ++i) {
      error.sum += squared_difference(row_a + i, row_b + i);
    }
  }
  return error;
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

}  // namespace

double psnr_db(double mean_squared_error) {
  if (mean_squared_error == 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(kPeak * kPeak / mean_squared_error);
}

double mean_squared_error(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  require_comparable(a, b, mask);
  std::int64_t sum = 0;
  std::int64_t pixels = 0;
  for (int row = 0; row < a.rows; ++row) {
    const RowError error = row_error(a, b, mask, row);
    sum += error.sum;
    pixels += error.pixels;
  }
  return static_cast<double>(sum) / (static_cast<double>(pixels) * kChannels);
}

double psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  return psnr_db(mean_squared_error(a, b, mask));
}

double ws_psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  require_comparable(a, b, mask);
  const PanoramaSize size{a.cols, a.rows};
  double weighted_error = 0.0;
  double weight_sum = 0.0;
  for (int row = 0; row < a.rows; ++row) {
    const PixelPosition pixel{0.0, static_cast<double>(row)};
    const double weight = std::cos(angles_from_pixel(pixel, size).phi_rad);
    const RowError error = row_error(a, b, mask, row);
    weighted_error += weight * static_cast<double>(error.sum);
    weight_sum += weight * static_cast<double>(error.pixels);
  }
  return psnr_db(weighted_error / (weight_sum * kChannels));
}

}  // namespace raywalk
