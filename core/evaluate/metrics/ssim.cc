#include "core/evaluate/metrics/ssim.h"

#include <cstdint>
#include <vector>

#include "core/evaluate/metrics/image_pair.h"
#include "core/evaluate/metrics/luma.h"

namespace raywalk {
namespace {

constexpr int kCell = 4;                // a block is 2 x 2 cells, so that neighbours share cells
constexpr int kBlock = 2 * kCell;       // pixels
constexpr double kN = kBlock * kBlock;  // samples of a block

// ffmpeg holds both constants as integers, scaled like the sums they are added to, C1 by 64 and C2
// by 64 * 63: 6.5025 * 64 = 416.16 and 58.5225 * 64 * 63 = 235962.72, rounded. The sums that C1 is
// added to are products of two block sums and so carry 64^2; hence the effective C1 of ssim.h.
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

// The formula of ssim.h with its fractions cleared: means times N = 64, variances times N (N - 1),
//   N (N - 1) v = N sum x^2 - (sum x)^2.
double block_ssim(const Sums& sums) {
  const double a = sums.a;
  const double b = sums.b;
  const double variances = kN * sums.squares - a * a - b * b;
  const double covariance = kN * sums.products - a * b;
  return (2.0 * a * b + kScaledC1) * (2.0 * covariance + kScaledC2) /
         ((a * a + b * b + kScaledC1) * (variances + kScaledC2));
}

}  // namespace

double ssim(const cv::Mat& a, const cv::Mat& b) {
  require_image_pair(a, b, kBlock);
  const cv::Mat luma_a = luma_8bit(a);
  const cv::Mat luma_b = luma_8bit(b);
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
