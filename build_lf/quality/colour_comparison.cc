#include "build_lf/quality/colour_comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/panorama/transposed_border.h"

namespace raywalk::build_lf {
namespace {

constexpr int kBorder = 24;  // pixels; more than the motion between two stations
// Levels outside are clipped or dominated by noise and rounding.
constexpr int kDarkest = 10;
constexpr int kBrightest = 250;

bool usable(int level) { return level > kDarkest && level < kBrightest; }

// Weighted interquartile mean: nearly as robust as the median, but not restricted to the
// few values that ratios of integer levels can take.
class MiddleHalf {
 public:
  MiddleHalf() : bins_(static_cast<size_t>(2.0 * kRange / kBinWidth) + 1) {}

  void add(double value, double weight) {
    const double place = (std::clamp(value, -kRange, kRange) + kRange) / kBinWidth;
    Bin& bin = bins_[static_cast<size_t>(place)];
    bin.weight += weight;
    bin.weighted += weight * value;
    total_ += weight;
    ++count_;
  }
  int count() const { return count_; }
  double mean() const {
    const double from = 0.25 * total_;
    const double to = 0.75 * total_;
    double passed = 0.0;
    double sum = 0.0;
    for (const Bin& bin : bins_) {
      const double inside = std::min(passed + bin.weight, to) - std::max(passed, from);
      passed += bin.weight;
      if (inside > 0.0) sum += inside * bin.weighted / bin.weight;
    }
    return sum / (to - from);
  }

 private:
  struct Bin {
    double weight = 0.0;
    double weighted = 0.0;
  };
  static constexpr double kRange = 3.3;  // beyond ln(kBrightest / kDarkest)
  static constexpr double kBinWidth = 0.001;
  std::vector<Bin> bins_;
  double total_ = 0.0;
  int count_ = 0;
};

// cos(phi) of each column of a station image: the solid angle of its pixels.
std::vector<double> solid_angles(int columns) {
  std::vector<double> weights;
  weights.reserve(static_cast<size_t>(columns));
  for (int phi = 0; phi < columns; ++phi) weights.push_back(std::sin((phi + 0.5) / columns * kPi));
  return weights;
}

const std::array<double, 256>& logs_of_levels() {
  static const std::array<double, 256> logs = [] {
    std::array<double, 256> values{};
    for (size_t level = 1; level < values.size(); ++level) {
      values[level] = std::log(static_cast<double>(level));
    }
    return values;
  }();
  return logs;
}

// Computes the log ratios; false if there is too little to compare. Pixels are
// weighted by `trust` (CV_32F; 0: ignored) and by level, as rounding and noise change a log ratio
// in proportion to 1 / level.
bool measure_ratios(const cv::Mat& from, const cv::Mat& to, const cv::Mat& trust,
                    ColourComparison* comparison) {
  const std::vector<double> solid_angle = solid_angles(from.cols);
  const auto& logs = logs_of_levels();
  constexpr double kLeastShare = 0.02;
  for (int channel = 0; channel < 3; ++channel) {
    MiddleHalf ratios;
    for (int row = 0; row < from.rows; ++row) {
      const auto* a = from.ptr<cv::Vec3b>(row);
      const auto* b = to.ptr<cv::Vec3b>(row);
      const auto* trusted = trust.ptr<float>(row);
      for (int col = 0; col < from.cols; ++col) {
        const int level_a = a[col][channel];
        const int level_b = b[col][channel];
        if (!usable(level_a) || !usable(level_b) || trusted[col] == 0.0F) continue;
        const double weight =
            solid_angle[static_cast<size_t>(col)] * trusted[col] * (level_a + level_b);
        ratios.add(logs[static_cast<size_t>(level_b)] - logs[static_cast<size_t>(level_a)], weight);
      }
    }
    if (ratios.count() < kLeastShare * static_cast<double>(from.total())) return false;
    comparison->log_ratio[static_cast<size_t>(channel)] = ratios.mean();
  }
  return true;
}

// Root mean square difference of `from` and of `to` over `ratio`, both unclipped, where `valid` is
// not 0 (empty: everywhere).
double rms_difference(const cv::Mat& from, const cv::Mat& to, const cv::Mat& valid,
                      const std::array<double, 3>& log_ratio) {
  const std::vector<double> solid_angle = solid_angles(from.cols);
  double sum = 0.0;
  double weight = 0.0;
  for (size_t channel = 0; channel < 3; ++channel) {
    const double scale = std::exp(-log_ratio[channel]);
    const int c = static_cast<int>(channel);
    for (int row = 0; row < from.rows; ++row) {
      const auto* a = from.ptr<cv::Vec3b>(row);
      const auto* b = to.ptr<cv::Vec3b>(row);
      const std::uint8_t* counts = valid.empty() ? nullptr : valid.ptr(row);
      for (int col = 0; col < from.cols; ++col) {
        if (!usable(a[col][c]) || !usable(b[col][c])) continue;
        if (counts != nullptr && counts[col] == 0) continue;
        const double difference = scale * b[col][c] - a[col][c];
        sum += solid_angle[static_cast<size_t>(col)] * difference * difference;
        weight += solid_angle[static_cast<size_t>(col)];
      }
    }
  }
  return weight > 0.0 ? std::sqrt(sum / weight) : 0.0;
}

// Pixels whose levels count in both images and that are `valid` (empty: all), CV_32FC3 of 0 and 1.
cv::Mat countable(const cv::Mat& from, const cv::Mat& to, const cv::Mat& valid) {
  cv::Mat counts(from.size(), CV_32FC3, cv::Scalar::all(0));
  for (int row = 0; row < from.rows; ++row) {
    for (int col = 0; col < from.cols; ++col) {
      if (!valid.empty() && valid.at<uchar>(row, col) == 0) continue;
      for (int c = 0; c < 3; ++c) {
        const bool both =
            usable(from.at<cv::Vec3b>(row, col)[c]) && usable(to.at<cv::Vec3b>(row, col)[c]);
        counts.at<cv::Vec3f>(row, col)[c] = both ? 1.0F : 0.0F;
      }
    }
  }
  return counts;
}

// `to` with the local means of `from`, around each pixel and in each channel: exposures that differ
// only here and there, as between the lenses of a camera or under clouds, are no change of what is
// seen. They are at most half a stop off the ratio of the whole pictures; objects that come and go
// differ by more.
cv::Mat with_means_of(const cv::Mat& from, const cv::Mat& to, const cv::Mat& valid,
                      const std::array<double, 3>& log_ratio) {
  // 6 degrees: a small part of a lens's picture, and wider than parallax that the flow misses.
  constexpr double kSigmaPerWidth = 1.0 / 64.0;
  constexpr double kSigmas = 3.0;
  const double sigma_px = kSigmaPerWidth * from.rows;
  const int border_px = static_cast<int>(std::ceil(kSigmas * sigma_px));
  const cv::Mat counts = countable(from, to, valid);
  const auto local_sums = [&](const cv::Mat& image) {
    cv::Mat levels;
    image.convertTo(levels, CV_32F);
    cv::Mat sums = with_border(levels.mul(counts), border_px);
    cv::GaussianBlur(sums, sums, {}, sigma_px);
    return without_border(sums, border_px).clone();
  };
  const cv::Mat sums_to = local_sums(to);
  cv::Mat ratio;
  cv::divide(local_sums(from), sums_to, ratio);
  const double most = std::sqrt(2.0);
  const cv::Scalar whole(std::exp(-log_ratio[0]), std::exp(-log_ratio[1]), std::exp(-log_ratio[2]));
  cv::min(ratio, whole * most, ratio);
  cv::max(ratio, whole * (1.0 / most), ratio);
  cv::Mat levels;
  to.convertTo(levels, CV_32F);
  cv::multiply(levels, ratio, levels);
  levels.convertTo(levels, CV_8U);
  return levels;
}

cv::Mat grey(const cv::Mat& image, double scale) {
  cv::Mat single;
  cv::cvtColor(image, single, cv::COLOR_RGB2GRAY);
  single.convertTo(single, CV_8U, scale);
  return single;
}

// Both images warped to the viewpoint half way, so that they show the same surfaces. Both are
// warped because interpolation blurs, and blur raises the mean of logarithms: warping only one
// would cause a bias that accumulates from station to station.
struct HalfwayImages {
  cv::Mat from;
  cv::Mat to;
};

// `bordered` sampled at `share` of the flow from each pixel; without its border.
cv::Mat moved_along(const cv::Mat& flow, float share, const cv::Mat& bordered) {
  cv::Mat places(flow.size(), CV_32FC2);
  for (int row = 0; row < flow.rows; ++row) {
    const auto* displacement = flow.ptr<cv::Vec2f>(row);
    auto* place = places.ptr<cv::Vec2f>(row);
    for (int col = 0; col < flow.cols; ++col) {
      place[col] =
          cv::Vec2f(static_cast<float>(col), static_cast<float>(row)) + share * displacement[col];
    }
  }
  cv::Mat moved;
  cv::remap(bordered, moved, places, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return without_border(moved, kBorder);
}

// `scale` adjusts `to` to the exposure of `from`, as Farnebaeck's flow assumes equal brightness.
// The flow at `from` approximates the flow at the half-way view, as it varies slowly.
HalfwayImages meet_halfway(const cv::Mat& from, const cv::Mat& to, double scale) {
  constexpr double kPyramidScale = 0.5;
  constexpr int kLevels = 4;
  constexpr int kIterations = 3;
  constexpr int kNeighbourhood = 5;
  constexpr double kSmoothing = 1.1;
  const cv::Mat bordered_from = with_border(from, kBorder);
  const cv::Mat bordered_to = with_border(to, kBorder);
  cv::Mat flow;
  cv::calcOpticalFlowFarneback(grey(bordered_from, 1.0), grey(bordered_to, scale), flow,
                               kPyramidScale, kLevels, kFlowWindow, kIterations, kNeighbourhood,
                               kSmoothing, 0);
  return {moved_along(flow, -0.5f, bordered_from), moved_along(flow, 0.5f, bordered_to)};
}

// Reliability of the flow, 0 to 1: flow is reliable where there is contrast in every direction, as
// at corners. On a smooth brightness gradient the flow lags behind, and moving towards a lamp would
// look like a longer exposure. The measure is the lesser eigenvalue of the mean of gradient *
// gradient^T (Shi and Tomasi 1994).
cv::Mat trust_in_flow(const cv::Mat& image) {
  constexpr int kNeighbourhood = 7;
  constexpr int kSobel = 3;
  // OpenCV scales Sobel's sums, 8 times the gradient, by 1 / (4 * 7), and adds up 7 * 7 products.
  constexpr double kPerMeanSquare = 4.0;
  constexpr double kClearLevelsPerPixel = 8.0;
  cv::Mat contrast;
  cv::cornerMinEigenVal(with_border(grey(image, 1.0), kNeighbourhood), contrast, kNeighbourhood,
                        kSobel);
  contrast = without_border(contrast, kNeighbourhood) / kPerMeanSquare;
  // In an image without texture all pixels have equal weight.
  constexpr double kLeast = 1e-6;
  return contrast / (contrast + kClearLevelsPerPixel * kClearLevelsPerPixel) + kLeast;
}

// Pixels valid in both.
cv::Mat valid_in_both(const ComparedPicture& a, const ComparedPicture& b) {
  if (a.valid.empty()) return b.valid;
  return b.valid.empty() ? a.valid : a.valid & b.valid;
}

}  // namespace

ColourComparison compare_colours(const ComparedPicture& first, const ComparedPicture& second) {
  const cv::Mat& from = first.colours;
  const cv::Mat& to = second.colours;
  const cv::Mat valid = valid_in_both(first, second);
  const auto only_valid = [&](cv::Mat trust) {
    if (!valid.empty()) trust.setTo(0.0, valid == 0);
    return trust;
  };
  ColourComparison comparison;
  const auto& log_ratio = comparison.log_ratio;
  const cv::Mat alike = only_valid(cv::Mat(from.size(), CV_32F, cv::Scalar(1.0)));
  if (!measure_ratios(from, to, alike, &comparison)) return {};
  comparison.change = rms_difference(from, to, valid, log_ratio);
  const double mean_log = (log_ratio[0] + log_ratio[1] + log_ratio[2]) / 3.0;
  const HalfwayImages halfway = meet_halfway(from, to, std::exp(-mean_log));
  const cv::Mat trust = only_valid(trust_in_flow(halfway.from));
  if (!measure_ratios(halfway.from, halfway.to, trust, &comparison)) return {};
  constexpr std::array<double, 3> kSameMeans{};
  comparison.unexplained_change = rms_difference(
      halfway.from, with_means_of(halfway.from, halfway.to, valid, log_ratio), valid, kSameMeans);
  comparison.comparable = true;
  return comparison;
}

}  // namespace raywalk::build_lf
