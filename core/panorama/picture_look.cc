#include "core/panorama/picture_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/median.h"

namespace raywalk {
namespace {

constexpr int kHeight = 256;      // of the reduced picture, at most
constexpr int kLeastHeight = 64;  // fewer rows show too little

double spread(const cv::Mat& values) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(values, mean, deviation);
  return deviation[0];
}

// Mean absolute difference of two columns, without the rows near the poles, which have one colour.
double step_between(const cv::Mat& grey, int one, int other) {
  const cv::Range rows(grey.rows / 8, grey.rows - grey.rows / 8);
  return cv::norm(grey(rows, cv::Range(one, one + 1)), grey(rows, cv::Range(other, other + 1)),
                  cv::NORM_L1) /
         rows.size();
}

bool ends_in_points(const cv::Mat& grey) {
  constexpr double kLeastSpread = 8.0;  // grey levels along the horizon
  std::vector<double> spreads;
  spreads.reserve(static_cast<std::size_t>(grey.rows));
  for (int row = grey.rows / 3; row < 2 * grey.rows / 3; ++row) {
    spreads.push_back(spread(grey.row(row)));
  }
  const double horizon = median(spreads);
  const double poles = std::max(spread(grey.row(0)), spread(grey.row(grey.rows - 1)));
  return horizon >= kLeastSpread && poles <= 0.25 * horizon;
}

bool closes_around(const cv::Mat& grey) {
  std::vector<double> neighbours, far;
  for (int column = 0; column + 1 < grey.cols; ++column) {
    neighbours.push_back(step_between(grey, column, column + 1));
    far.push_back(step_between(grey, column, (column + grey.cols / 2) % grey.cols));
  }
  const double seam = step_between(grey, grey.cols - 1, 0);
  return seam <= *std::ranges::max_element(neighbours) && seam <= 0.5 * median(far);
}

// The brightness of a picture inside and outside the circle that fills one of its halves, by
// direction from the circle's centre.
struct Rings {
  static constexpr int kSectors = 24;
  std::array<double, kSectors> inside{};   // mean
  std::array<double, kSectors> outside{};  // mean; below 0 where the circle touches the edge
};

// Radii as fractions of half the height: circles differ in size and may be cut off a little.
Rings rings_of(const cv::Mat& half) {
  const double radius_px = 0.5 * half.rows;
  std::array<double, Rings::kSectors> sums_in{}, sums_out{}, counts_in{}, counts_out{};
  for (int v = 0; v < half.rows; ++v) {
    for (int u = 0; u < half.cols; ++u) {
      const double x = u + 0.5 - 0.5 * half.cols, y = v + 0.5 - radius_px;
      const double radius = std::hypot(x, y) / radius_px;
      const double turn = std::atan2(y, x) / (2.0 * std::numbers::pi) + 0.5;
      const auto sector = std::min(static_cast<std::size_t>(turn * Rings::kSectors),
                                   static_cast<std::size_t>(Rings::kSectors - 1));
      const double grey = half.at<uchar>(v, u);
      if (radius > 0.65 && radius < 0.85) {
        sums_in[sector] += grey;
        ++counts_in[sector];
      } else if (radius > 1.14) {
        sums_out[sector] += grey;
        ++counts_out[sector];
      }
    }
  }
  Rings rings;
  for (std::size_t i = 0; i < rings.inside.size(); ++i) {
    rings.inside[i] = sums_in[i] / std::max(1.0, counts_in[i]);
    rings.outside[i] = counts_out[i] < 4.0 ? -1.0 : sums_out[i] / counts_out[i];
  }
  return rings;
}

// Whether it is dark all around the circle, whatever it holds.
bool is_dark_around(const Rings& rings) {
  constexpr double kDark = 32.0;  // grey levels: black, with noise and flare
  return std::ranges::all_of(rings.outside, [](double grey) { return grey <= kDark; });
}

// Whether the circle is much lighter than what is around it, in nearly all directions.
bool is_light_within(const Rings& rings) {
  const double around = *std::ranges::max_element(rings.outside);
  const auto light =
      std::ranges::count_if(rings.inside, [&](double grey) { return grey >= 3.0 * around + 16.0; });
  return light * 8 >= 7 * Rings::kSectors;
}

}  // namespace

PictureKind look_at_picture(const cv::Mat& picture) {
  if (picture.rows < kLeastHeight || picture.cols != 2 * picture.rows) return PictureKind::kUnclear;
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  if (grey.rows > kHeight) {
    cv::resize(grey, grey, {2 * kHeight, kHeight}, 0.0, 0.0, cv::INTER_AREA);
  }
  const Rings left = rings_of(grey.colRange(0, grey.rows));
  const Rings right = rings_of(grey.colRange(grey.rows, grey.cols));
  if (is_dark_around(left) && is_dark_around(right)) {
    // Never a panorama: its black rows and edges would be those of one.
    return is_light_within(left) && is_light_within(right) ? PictureKind::kDualFisheye
                                                           : PictureKind::kUnclear;
  }
  return ends_in_points(grey) && closes_around(grey) ? PictureKind::kPanorama
                                                     : PictureKind::kUnclear;
}

PictureKind look_at_picture(std::span<const std::byte> file) {
  constexpr std::size_t kLargeFile = std::size_t{1} << 20;
  if (file.empty()) return PictureKind::kUnclear;
  const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8UC1,
                      const_cast<std::byte*>(file.data()));  // only read
  const int reduced =
      file.size() < kLargeFile ? cv::IMREAD_GRAYSCALE : cv::IMREAD_REDUCED_GRAYSCALE_4;
  try {
    return look_at_picture(cv::imdecode(bytes, reduced | cv::IMREAD_IGNORE_ORIENTATION));
  } catch (const cv::Exception&) {
    return PictureKind::kUnclear;
  }
}

}  // namespace raywalk
