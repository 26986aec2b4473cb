#include "core/evaluate/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

constexpr int kChannels = 3;
constexpr double kPeak = 255.0;

std::string size_text(const cv::Mat& image) { return fmt::format("{}x{}", image.cols, image.rows); }

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
  const std::uint8_t* selected = mask.empty() ? nullptr : mask.ptr(row);
  RowError error;
  for (int col = 0; col < a.cols; ++col) {
    if (selected != nullptr && selected[col] == 0) continue;
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

constexpr int kCell = 4;           // a block of SSIM is 2 x 2 cells, so that neighbours share them
constexpr int kBlock = 2 * kCell;  // pixels
constexpr double kN = kBlock * kBlock;  // samples of a block

// ffmpeg holds both constants as integers, scaled like the sums they are added to, C1 by 64 and C2
// by 64 * 63: 6.5025 * 64 = 416.16 and 58.5225 * 64 * 63 = 235962.72, rounded. The sums that C1 is
// added to are products of two block sums and so carry 64^2; hence the effective C1 of metrics.h.
constexpr double kScaledC1 = 416.0;
constexpr double kScaledC2 = 235963.0;

// Sums over the pixels of a cell or a block. At most 2 * 64 * 255^2, far within 32 bits.
struct Sums {
  std::int32_t a = 0;
  std::int32_t b = 0;
  std::int32_t squares = 0;  // a^2 + b^2: only the sum of both variances is needed
  std::int32_t products = 0;

  Sums& operator+=(const Sums& other) {
    a += other.a;
    b += other.b;
    squares += other.squares;
    products += other.products;
    return *this;
  }
};

Sums cell_sums(const cv::Mat& a, const cv::Mat& b, int cell_row, int cell_col) {
  Sums sums;
  for (int row = cell_row * kCell; row < (cell_row + 1) * kCell; ++row) {
    const std::uint8_t* row_a = a.ptr(row, cell_col * kCell);
    const std::uint8_t* row_b = b.ptr(row, cell_col * kCell);
    for (int i = 0; i < kCell; ++i) {
      const int va = row_a[i];
      const int vb = row_b[i];
      sums += {va, vb, va * va + vb * vb, va * vb};
    }
  }
  return sums;
}

void fill_cell_row(const cv::Mat& a, const cv::Mat& b, int cell_row, std::vector<Sums>* cells) {
  for (int col = 0; col < static_cast<int>(cells->size()); ++col) {
    (*cells)[col] = cell_sums(a, b, cell_row, col);
  }
}

// The formula of metrics.h with its fractions cleared: means times N = 64, variances times
// N (N - 1), N (N - 1) v = N sum x^2 - (sum x)^2.
double block_ssim(const Sums& sums) {
  const double a = sums.a;
  const double b = sums.b;
  const double variances = kN * sums.squares - a * a - b * b;
  const double covariance = kN * sums.products - a * b;
  return (2.0 * a * b + kScaledC1) * (2.0 * covariance + kScaledC2) /
         ((a * a + b * b + kScaledC1) * (variances + kScaledC2));
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

double ssim(const cv::Mat& a, const cv::Mat& b) {
  require_image_pair(a, b, kBlock);
  cv::Mat luma_a, luma_b;
  cv::cvtColor(a, luma_a, cv::COLOR_BGR2GRAY);
  cv::cvtColor(b, luma_b, cv::COLOR_BGR2GRAY);
  const int cell_rows = a.rows / kCell;
  const int cell_cols = a.cols / kCell;
  std::vector<Sums> above(cell_cols);
  std::vector<Sums> below(cell_cols);
  fill_cell_row(luma_a, luma_b, 0, &above);
  double sum = 0.0;
  for (int row = 1; row < cell_rows; ++row) {
    fill_cell_row(luma_a, luma_b, row, &below);
    for (int col = 1; col < cell_cols; ++col) {
      Sums block = above[col - 1];
      block += above[col];
      block += below[col - 1];
      block += below[col];
      sum += block_ssim(block);
    }
    above.swap(below);
  }
  return sum / (static_cast<double>(cell_rows - 1) * (cell_cols - 1));
}

}  // namespace raywalk
