#include "core/view/smooth_distances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/geometry/fast_math.h"
#include "core/geometry/panorama_pixels.h"
#include "core/view/unknown_pixels.h"

namespace raywalk {
namespace {

// Side of a cell in pixels of the distances.
constexpr int kCell = 4;

int cells_along(int pixels) { return (pixels + kCell - 1) / kCell; }

// Trust in a single pixel, 0 to kFullTrust: none at kMinConfidence, full where half of the votes
// agree.
constexpr int kFullTrust = 128 - kMinConfidence;
constexpr std::uint8_t trust_of(std::uint8_t confidence) {
  return static_cast<std::uint8_t>(std::clamp(confidence - kMinConfidence, 0, kFullTrust));
}

// From the share of trusted pixels around a place to the trust in it, without a kink.
float trust_of_share(float share) {
  const float x = std::clamp(2.0f * share - 0.5f, 0.0f, 1.0f);
  return x * x * (3.0f - 2.0f * x);
}

// Blurs a panorama of cells, around its seam.
void blur(cv::Mat* cells) {
  constexpr int kBeyond = 3;
  cv::Mat wide;
  cv::copyMakeBorder(*cells, wide, 0, 0, kBeyond, kBeyond, cv::BORDER_WRAP);
  cv::GaussianBlur(wide, wide, cv::Size(2 * kBeyond + 1, 2 * kBeyond + 1), 1.5, 1.5,
                   cv::BORDER_REPLICATE);
  wide.colRange(kBeyond, kBeyond + cells->cols).copyTo(*cells);
}

// Bilinear; `u` and `v` in cells, from the first one's centre.
float value_at(const cv::Mat& cells, float u, float v) {
  const float left_u = std::floor(u);
  const float held_v = std::clamp(v, 0.0f, static_cast<float>(cells.rows - 1));
  const int upper = static_cast<int>(held_v);
  const int lower = std::min(upper + 1, cells.rows - 1);
  const int left = wrapped_column(static_cast<int>(left_u), cells.cols);
  const int right = left + 1 == cells.cols ? 0 : left + 1;
  const float part = u - left_u;
  const auto across = [&](int row) {
    const auto* values = cells.ptr<float>(row);
    return values[left] + (values[right] - values[left]) * part;
  };
  return across(upper) + (across(lower) - across(upper)) * (held_v - static_cast<float>(upper));
}

// The middle of some values; reorders them. Not of none.
float median_of(std::span<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The seen inverse distances in a cell and `margin` pixels around it, into `seen`.
std::span<float> seen_around(std::span<const float> omega, PanoramaSize size, cv::Point cell,
                             int margin, std::span<float> seen) {
  size_t count = 0;
  const int first_row = std::max(kCell * cell.y - margin, 0);
  const int end_row = std::min(kCell * (cell.y + 1) + margin, size.height);
  for (int u = kCell * cell.x - margin; u < kCell * (cell.x + 1) + margin; ++u) {
    const auto column = static_cast<size_t>(wrapped_column(u, size.width));
    const float* rows = omega.data() + column * static_cast<size_t>(size.height);
    for (int row = first_row; row < end_row; ++row) {
      if (rows[row] >= 0.0f) seen[count++] = rows[row];
    }
  }
  return seen.first(count);
}

// Calls body(cell) for all cells, on several threads.
template <typename Body>
void for_each_cell(const cv::Mat& cells, const Body& body) {
  parallel_for(0, cells.rows, 4, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < cells.cols; ++x) body(cv::Point(x, y));
    }
  });
}

constexpr int kMargin = kCell;  // of the pixels that a doubted cell's median is of
constexpr int kWindow = (kCell + 2 * kMargin) * (kCell + 2 * kMargin);
using Window = std::array<float, kWindow>;

// One of the inverse distances seen in each cell, filled where none is.
cv::Mat sampled_distances(std::span<const float> omega, PanoramaSize size, cv::Size cells) {
  cv::Mat samples(cells, CV_32FC1);
  cv::Mat weights(cells, CV_32FC1);
  for_each_cell(samples, [&](cv::Point cell) {
    const int theta = std::min(kCell * cell.x + kCell / 2, size.width - 1);
    const int row = std::min(kCell * cell.y + kCell / 2, size.height - 1);
    float sample = omega[static_cast<size_t>(theta) * static_cast<size_t>(size.height) +
                         static_cast<size_t>(row)];
    if (sample < 0.0f) {
      Window window;
      const auto seen = seen_around(omega, size, cell, 0, window);
      if (!seen.empty()) sample = seen[seen.size() / 2];
    }
    weights.at<float>(cell) = sample < 0.0f ? 0.0f : 1.0f;
    samples.at<float>(cell) = std::max(sample, 0.0f);
  });
  // Where nothing at all is known, everything is infinitely far.
  if (!fill_unknown(samples, weights, Seam::kJoined)) samples = 0.0;
  return samples;
}

}  // namespace

void MapTrust::compute(const DistanceVolume& volume, int map) {
  const PanoramaSize size = volume.size();
  cells_ = cv::Mat::zeros(cells_along(size.height), cells_along(size.width), CV_32FC1);
  cv::Mat counts = cells_.clone();
  std::vector<std::uint8_t> trust(static_cast<size_t>(size.height));
  for (int theta = 0; theta < size.width; ++theta) {
    const auto distance = volume.distance_column(map, theta);
    const auto confidence = volume.confidence_column(map, theta);
    for (size_t row = 0; row < trust.size(); ++row) {
      trust[row] = distance[row] > 0.0f ? trust_of(confidence[row]) : std::uint8_t{0};
    }
    const int x = theta / kCell;
    for (int y = 0; y < cells_.rows; ++y) {
      const int end = std::min(kCell * (y + 1), size.height);
      int sum = 0;
      for (int row = kCell * y; row < end; ++row) sum += trust[static_cast<size_t>(row)];
      cells_.at<float>(y, x) += static_cast<float>(sum) / kFullTrust;
      counts.at<float>(y, x) += static_cast<float>(end - kCell * y);
    }
  }
  cells_ /= counts;
  blur(&cells_);
  everywhere_ = true;
  for (int row = 0; row < cells_.rows; ++row) {
    for (float& cell : std::span(cells_.ptr<float>(row), static_cast<size_t>(cells_.cols))) {
      cell = trust_of_share(cell);
      everywhere_ &= cell >= 1.0f;
    }
  }
}

float MapTrust::at(const Eigen::Vector3f& direction) const {
  const float plan = std::hypot(direction.x(), direction.z());
  const float u = (fast_atan2(direction.x(), direction.z()) / static_cast<float>(kTwoPi) + 0.5f) *
                  static_cast<float>(cells_.cols);
  const float v = (0.5f - fast_atan2(direction.y(), plan) / static_cast<float>(kPi)) *
                  static_cast<float>(cells_.rows);
  return value_at(cells_, u - 0.5f, v - 0.5f);
}

void SmoothDistances::compute(std::span<const float> omega, PanoramaSize size, const EyeCircle& eye,
                              std::span<const TrustedMap> maps) {
  size_ = size;
  const cv::Size cells(cells_along(size.width), cells_along(size.height));
  omega_ = sampled_distances(omega, size, cells);
  find_trust(omega_, eye, maps);
  cv::Mat weights(cells, CV_32FC1, cv::Scalar(1.0));
  for_each_cell(omega_, [&](cv::Point cell) {
    if (trust_.at<float>(cell) >= 1.0f) return;
    Window window;
    const auto seen = seen_around(omega, size, cell, kMargin, window);
    constexpr float kEnough = 0.25f * kWindow;
    weights.at<float>(cell) = std::min(1.0f, static_cast<float>(seen.size()) / kEnough);
    if (!seen.empty()) omega_.at<float>(cell) = median_of(seen);
  });
  fill_unknown(omega_, weights, Seam::kJoined);
}

void SmoothDistances::find_trust(const cv::Mat& omega, const EyeCircle& eye,
                                 std::span<const TrustedMap> maps) {
  trust_.create(omega.size(), CV_32FC1);
  const PanoramaSize cells{omega.cols, omega.rows};
  for_each_cell(omega, [&](cv::Point cell) {
    const SphereAngles angles = angles_from_pixel({double(cell.x), double(cell.y)}, cells);
    const Eigen::Vector3f direction = direction_from_angles(angles).cast<float>();
    const Eigen::Vector3d eye_m = eye.position_m(angles.theta_rad);
    float most = 0.0f;
    for (const TrustedMap& map : maps) {
      if (most >= 1.0f) break;
      const Eigen::Vector3f offset_m = (eye_m - map.position_m).cast<float>();
      most = std::max(most, map.trust->at(direction + omega.at<float>(cell) * offset_m));
    }
    trust_.at<float>(cell) = most;
  });
  blur(&trust_);
  doubted_.assign(static_cast<size_t>(trust_.cols), 0);
  for (int y = 0; y < trust_.rows; ++y) {
    for (int x = 0; x < trust_.cols; ++x) {
      float& trust = trust_.at<float>(y, x);
      if (trust > 0.9999f) trust = 1.0f;  // up to the rounding of the blur
      if (trust < 1.0f) doubted_[static_cast<size_t>(x)] = 1;
    }
  }
}

void SmoothDistances::interpolate(const cv::Mat& cells, int theta, std::span<float> out) const {
  const float u = (static_cast<float>(theta) + 0.5f) * static_cast<float>(cells.cols) /
                      static_cast<float>(size_.width) -
                  0.5f;
  std::vector<float> column(static_cast<size_t>(cells.rows) + 1);
  for (int y = 0; y <= cells.rows; ++y) {
    column[static_cast<size_t>(y)] = value_at(cells, u, static_cast<float>(y));
  }
  const float cells_per_row = static_cast<float>(cells.rows) / static_cast<float>(size_.height);
  for (size_t row = 0; row < out.size(); ++row) {
    const float v = std::max(0.0f, (static_cast<float>(row) + 0.5f) * cells_per_row - 0.5f);
    const auto upper = static_cast<size_t>(v);
    const float part = v - static_cast<float>(upper);
    out[row] = column[upper] + (column[upper + 1] - column[upper]) * part;
  }
}

bool SmoothDistances::is_doubted(int theta) const {
  const int x = theta / kCell;
  for (const int beside : {x - 1, x, x + 1}) {
    if (doubted_[static_cast<size_t>(wrapped_column(beside, trust_.cols))] != 0) return true;
  }
  return false;
}

bool SmoothDistances::trust(int theta, std::span<float> trust) const {
  if (!is_doubted(theta)) return false;
  interpolate(trust_, theta, trust);
  return true;
}

void SmoothDistances::smooth(int theta, std::span<const float> trust,
                             std::span<float> omega) const {
  std::vector<float> smooth(omega.size());
  interpolate(omega_, theta, smooth);
  for (size_t row = 0; row < omega.size(); ++row) {
    if (trust[row] < 1.0f) omega[row] = smooth[row] + (omega[row] - smooth[row]) * trust[row];
  }
}

}  // namespace raywalk
