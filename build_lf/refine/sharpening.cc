#include "build_lf/refine/sharpening.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/parallel.h"
#include "core/panorama/transposed_border.h"

namespace raywalk::build_lf {
namespace {

constexpr int kBorder = 16;  // pixels, more than the filters reach

// Strips of columns of the photograph that begin and end where columns of the picture do. Pictures
// of floats of a whole panorama of 8192 columns would take gigabytes.
std::vector<cv::Range> strips_of(int captured_width, int width) {
  constexpr int kColumns = 128;
  const int unit = captured_width / std::gcd(captured_width, width);
  const int columns = unit * ((kColumns + unit - 1) / unit);
  std::vector<cv::Range> strips;
  for (int first = 0; first < captured_width; first += columns) {
    strips.emplace_back(first, std::min(first + columns, captured_width));
  }
  return strips;
}

cv::Range in_picture(cv::Range strip, int captured_width, int width) {
  const int unit = captured_width / std::gcd(captured_width, width);
  const int unit_there = width / std::gcd(captured_width, width);
  return {strip.start / unit * unit_there, strip.end / unit * unit_there};
}

// The levels of a strip of a picture of which `bordered` has a border, with the border.
cv::Mat levels_of(const cv::Mat& bordered, cv::Range strip) {
  cv::Mat levels;
  bordered.rowRange(strip.start, strip.end + 2 * kBorder).convertTo(levels, CV_32F, 1.0 / kLevel);
  return levels;
}

// By half a captured pixel.
cv::Mat blurred(const cv::Mat& picture, int captured_width, int width) {
  const double sigma_px = 0.5 * width / captured_width;
  cv::Mat result;
  cv::GaussianBlur(picture, result, {}, sigma_px);
  return result;
}

// What views of the captured width show of it on average: bilinear samples at places all over the
// pixels, averaged over a pixel of the view. `shown_size` is that of the strip in the photograph.
cv::Mat as_views_show(const cv::Mat& picture, cv::Size shown_size) {
  const cv::Mat kernel = (cv::Mat1f(1, 3) << 1.0f / 6.0f, 2.0f / 3.0f, 1.0f / 6.0f);
  cv::Mat sampled, shown;
  cv::sepFilter2D(picture, sampled, -1, kernel, kernel);
  cv::resize(without_border(sampled, kBorder), shown, shown_size, 0.0, 0.0, cv::INTER_AREA);
  return shown;
}

// Sums of the least squares: s = missing / there.
struct Fit {
  double missing = 0.0, there = 0.0;
  int count = 0;
};

// Of a strip; `photograph` and `comparable` are of its columns.
Fit fit_of(const cv::Mat& picture, const cv::Mat& detail, const cv::Mat& photograph,
           const cv::Mat& comparable) {
  constexpr float kContradicts = 25.0f;  // levels: not a matter of sharpness
  constexpr double kSteepest = 60.0;     // degrees of latitude: beyond, columns are oversampled
  const cv::Mat shown = as_views_show(picture, photograph.size());
  const cv::Mat fine_shown = as_views_show(detail, photograph.size());
  const auto first = static_cast<int>(photograph.cols * (0.5 - kSteepest / 180.0));
  Fit fit;
  for (int theta = 0; theta < photograph.rows; ++theta) {
    for (int phi = first; phi < photograph.cols - first; ++phi) {
      if (comparable.at<std::uint8_t>(theta, phi) == 0) continue;
      const cv::Vec3f off =
          cv::Vec3f(photograph.at<cv::Vec3b>(theta, phi)) - shown.at<cv::Vec3f>(theta, phi);
      if (std::max({std::fabs(off[0]), std::fabs(off[1]), std::fabs(off[2])}) > kContradicts) {
        continue;
      }
      const auto& fine = fine_shown.at<cv::Vec3f>(theta, phi);
      fit.missing += off.dot(fine);
      fit.there += fine.dot(fine);
      ++fit.count;
    }
  }
  return fit;
}

// Pixels of the photograph for which `others` has all pixels that the filters reach.
cv::Mat known_pixels(const cv::Mat& others, cv::Size photograph) {
  cv::Mat unknown;
  cv::inRange(others, cv::Scalar::all(0), cv::Scalar::all(0), unknown);
  cv::dilate(with_border(unknown, kBorder), unknown, cv::Mat::ones(9, 9, CV_8U));
  cv::resize(without_border(unknown, kBorder), unknown, photograph, 0.0, 0.0, cv::INTER_AREA);
  return unknown == 0;
}

}  // namespace

double measured_sharpening(const cv::Mat& others, const cv::Mat& photograph,
                           const cv::Mat1b& comparable) {
  constexpr int kFewest = 1000;  // pixels
  const cv::Mat usable = known_pixels(others, photograph.size()) & comparable;
  const cv::Mat bordered = with_border(others, kBorder);
  const std::vector<cv::Range> strips = strips_of(photograph.rows, others.rows);
  std::vector<Fit> fits(strips.size());
  parallel_for(0, static_cast<int>(strips.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const cv::Mat picture =
          levels_of(bordered, in_picture(strips[i], photograph.rows, others.rows));
      const cv::Mat detail = picture - blurred(picture, photograph.rows, others.rows);
      fits[i] = fit_of(picture, detail, photograph.rowRange(strips[i]), usable.rowRange(strips[i]));
    }
  });
  Fit all;
  for (const Fit& fit : fits) {
    all.missing += fit.missing;
    all.there += fit.there;
    all.count += fit.count;
  }
  if (all.count < kFewest || all.there <= 0.0) return 1.0;
  return std::clamp(all.missing / all.there, 0.0, 2.0);
}

cv::Mat sharpened(const cv::Mat& colour, int captured_width, double amount) {
  const cv::Mat bordered = with_border(colour, kBorder);
  cv::Mat result(colour.size(), CV_8UC3);
  const std::vector<cv::Range> strips = strips_of(captured_width, colour.rows);
  parallel_for(0, static_cast<int>(strips.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const cv::Range strip =
          in_picture(strips[static_cast<std::size_t>(i)], captured_width, colour.rows);
      const cv::Mat picture = levels_of(bordered, strip);
      const cv::Mat blur = blurred(picture, captured_width, colour.rows);
      cv::Mat to = result.rowRange(strip);
      without_border((1.0 + amount) * picture - amount * blur, kBorder).convertTo(to, CV_8U);
    }
  });
  return result;
}

}  // namespace raywalk::build_lf
