#include "render/metrics/psnr.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/error.h"
#include "core/geometry/sphere.h"
#include "render/metrics/image_pair.h"

namespace raywalk {
namespace {

constexpr int kChannels = 3;
constexpr double kPeak = 255.0;

std::int64_t squared_difference(const std::uint8_t* a, const std::uint8_t* b) {
  const int difference = int{*a} - int{*b};
  return std::int64_t{difference} * difference;
}

// Sum of squared differences over one row. Exact: a row of 2^31 samples stays below 2^47.
std::int64_t row_squared_error(const cv::Mat& a, const cv::Mat& b, int row) {
  const std::uint8_t* row_a = a.ptr(row);
  const std::uint8_t* row_b = b.ptr(row);
  std::int64_t sum = 0;
  for (int i = 0; i < kChannels * a.cols; ++i) sum += squared_difference(row_a + i, row_b + i);
  return sum;
}

double unmasked_mean_squared_error(const cv::Mat& a, const cv::Mat& b) {
  std::int64_t sum = 0;
  for (int row = 0; row < a.rows; ++row) sum += row_squared_error(a, b, row);
  return static_cast<double>(sum) / (static_cast<double>(a.total()) * kChannels);
}

double masked_mean_squared_error(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  std::int64_t sum = 0;
  std::int64_t pixels = 0;
  for (int row = 0; row < a.rows; ++row) {
    const std::uint8_t* row_a = a.ptr(row);
    const std::uint8_t* row_b = b.ptr(row);
    const std::uint8_t* selected = mask.ptr(row);
    for (int col = 0; col < a.cols; ++col) {
      if (selected[col] == 0) continue;
      ++pixels;
      for (int i = kChannels * col; i < kChannels * (col + 1); ++i) {
        sum += squared_difference(row_a + i, row_b + i);
      }
    }
  }
  if (pixels == 0) {
    throw Error("cannot compare images: the mask selects no pixel; give one that does");
  }
  return static_cast<double>(sum) / (static_cast<double>(pixels) * kChannels);
}

double decibels_from_mean_squared_error(double mean_squared_error) {
  if (mean_squared_error == 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(kPeak * kPeak / mean_squared_error);
}

}  // namespace

double mean_squared_error(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  require_image_pair(a, b, 1);
  if (mask.empty()) return unmasked_mean_squared_error(a, b);
  if (mask.type() != CV_8UC1 || mask.size() != a.size()) {
    throw Error("cannot compare images: the mask must be 8-bit, one channel, of the images' size");
  }
  return masked_mean_squared_error(a, b, mask);
}

double psnr_db(const cv::Mat& a, const cv::Mat& b) {
  return decibels_from_mean_squared_error(mean_squared_error(a, b));
}

double ws_psnr_db(const cv::Mat& a, const cv::Mat& b) {
  require_image_pair(a, b, 1);
  const PanoramaSize size{a.cols, a.rows};
  double weighted_error = 0.0;
  double weight_sum = 0.0;
  for (int row = 0; row < a.rows; ++row) {
    const PixelPosition pixel{0.0, static_cast<double>(row)};
    const double weight = std::cos(angles_from_pixel(pixel, size).phi_rad);
    weighted_error += weight * static_cast<double>(row_squared_error(a, b, row));
    weight_sum += weight;
  }
  const double samples_per_row = static_cast<double>(a.cols) * kChannels;
  return decibels_from_mean_squared_error(weighted_error / (weight_sum * samples_per_row));
}

}  // namespace raywalk
