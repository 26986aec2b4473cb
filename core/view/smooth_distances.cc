#include "core/view/smooth_distances.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/geometry/panorama_pixels.h"
#include "core/view/unknown_pixels.h"

namespace raywalk {
namespace {

// Side of a cell in pixels of the distances.
constexpr int kCell = 4;

// Trust in a single pixel, 0 to 1: none at kMinConfidence, full where half of the votes agree.
float trust_of(float distance_m, std::uint8_t confidence) {
  if (!(distance_m > 0.0f)) return 0.0f;
  return std::clamp((confidence - kMinConfidence) / (128.0f - kMinConfidence), 0.0f, 1.0f);
}

// From the share of trusted pixels around a place to the trust in it, without a kink.
float trust_of_share(float share) {
  const float x = std::clamp(2.0f * share - 0.5f, 0.0f, 1.0f);
  return x * x * (3.0f - 2.0f * x);
}

// Blurs a panorama of cells, around its seam.
void blur(cv::Mat1f* cells) {
  constexpr int kReach = 3;
  cv::Mat1f wide;
  cv::copyMakeBorder(*cells, wide, 0, 0, kReach, kReach, cv::BORDER_WRAP);
  cv::GaussianBlur(wide, wide, {2 * kReach + 1, 2 * kReach + 1}, 1.5, 1.5, cv::BORDER_REPLICATE);
  wide.colRange(kReach, kReach + cells->cols).copyTo(*cells);
}

// The inverse distances that most of what is seen around each cell has.
cv::Mat1f usual_distances(std::span<const float> omega, PanoramaSize size) {
  constexpr int kReach = 2;  // cells of a median
  const cv::Mat1f columns(size.width, size.height, const_cast<float*>(omega.data()));
  cv::Mat1f wide;
  cv::copyMakeBorder(columns.t(), wide, 0, 0, kReach * kCell, kReach * kCell, cv::BORDER_WRAP);
  // Medians of medians: of every second pixel, then of every second of those. Unseen pixels are
  // negative, so that a median is negative where most are unseen.
  for (int pixels = 1; pixels < kCell; pixels *= 2) {
    cv::resize(wide, wide, (wide.size() + cv::Size(1, 1)) / 2, 0, 0, cv::INTER_NEAREST);
    cv::medianBlur(wide, wide, 2 * kReach + 1);
  }
  cv::Mat cells = wide.colRange(kReach, wide.cols - kReach).clone();
  // Where nothing at all is known, everything is infinitely far.
  if (!fill_unknown(cells < 0.0, Seam::kJoined, {0, cells.rows}, &cells)) cells = 0.0;
  return cells;
}

// The most that any map is trusted in each cell of a view.
cv::Mat1f trust_in_any(const cv::Mat1f& omega, const EyeCircle& eye,
                       std::span<const TrustedMap> maps) {
  cv::Mat1f trust = cv::Mat1f::zeros(omega.size());
  trust.forEach([&](float& most, const int* cell) {
    const SphereAngles angles =
        angles_from_pixel({double(cell[1]), double(cell[0])}, {omega.cols, omega.rows});
    const Eigen::Vector3f direction = direction_from_angles(angles).cast<float>();
    const Eigen::Vector3d eye_m = eye.position_m(angles.theta_rad);
    for (const TrustedMap& map : maps) {
      if (most >= 1.0f) break;
      const Eigen::Vector3f offset_m = (eye_m - map.position_m).cast<float>();
      most = std::max(most, map.trust->at(direction + omega(cell) * offset_m));
    }
  });
  blur(&trust);
  trust.setTo(1.0, trust > 0.9999);  // up to the rounding of the blur
  return trust;
}

// Interpolates a panorama of cells at the pixels of distances, [theta][phi].
cv::Mat1f columns_of(const cv::Mat1f& cells, PanoramaSize size) {
  cv::Mat1f wide, columns;
  cv::copyMakeBorder(cells.t(), wide, 1, 1, 0, 0, cv::BORDER_WRAP);
  cv::resize(wide, columns, {}, kCell, kCell, cv::INTER_LINEAR);
  return columns(cv::Rect(0, kCell, size.height, size.width));
}

}  // namespace

void MapTrust::compute(const DistanceVolume& volume, int map) {
  const PanoramaSize size = volume.size();
  cv::Mat1f columns(size.width, size.height);
  for (int theta = 0; theta < size.width; ++theta) {
    std::ranges::transform(volume.distance_column(map, theta), volume.confidence_column(map, theta),
                           columns[theta], trust_of);
  }
  const cv::Size cells((size.width + kCell - 1) / kCell, (size.height + kCell - 1) / kCell);
  cv::resize(columns.t(), cells_, cells, 0, 0, cv::INTER_AREA);
  blur(&cells_);
  std::ranges::transform(cells_, cells_.begin(), trust_of_share);
  everywhere_ = std::ranges::all_of(cells_, [](float trust) { return trust >= 1.0f; });
}

float MapTrust::at(const Eigen::Vector3f& direction) const {
  const PanoramaSize cells{cells_.cols, cells_.rows};
  const SphereAngles angles = angles_from_direction(direction.cast<double>());
  const PixelsAround around = pixels_around(pixel_from_angles(angles, cells), cells);
  const auto in_row = [&](int row) {
    return std::lerp(cells_(row, around.column[0]), cells_(row, around.column[1]), around.part_u);
  };
  return static_cast<float>(std::lerp(in_row(around.row[0]), in_row(around.row[1]), around.part_v));
}

void SmoothDistances::compute(std::span<const float> omega, PanoramaSize size, const EyeCircle& eye,
                              std::span<const TrustedMap> maps) {
  const cv::Mat1f usual = usual_distances(omega, size);
  omega_ = columns_of(usual, size);
  trust_ = columns_of(trust_in_any(usual, eye, maps), size);
}

bool SmoothDistances::trust(int theta, std::span<float> trust) const {
  std::ranges::copy(cv::Mat1f(trust_.row(theta)), trust.begin());
  return std::ranges::any_of(trust, [](float value) { return value < 1.0f; });
}

void SmoothDistances::smooth(int theta, std::span<const float> trust,
                             std::span<float> omega) const {
  const float* const smooth = omega_[theta];
  for (size_t row = 0; row < omega.size(); ++row) {
    if (trust[row] < 1.0f) omega[row] = smooth[row] + (omega[row] - smooth[row]) * trust[row];
  }
}

}  // namespace raywalk
