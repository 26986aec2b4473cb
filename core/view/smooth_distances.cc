#include "core/view/smooth_distances.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
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

// All panoramas here are [theta][phi], as distances are: seams lie between the last row and the
// first. With `reach` more columns of the panorama on either side.
cv::Mat around_seam(const cv::Mat& columns, int reach) {
  cv::Mat wide;
  cv::copyMakeBorder(columns, wide, reach, reach, 0, 0, cv::BORDER_WRAP);
  return wide;
}

void blur(cv::Mat1f* cells) {
  constexpr int kReach = 3;
  cv::Mat wide = around_seam(*cells, kReach);
  cv::GaussianBlur(wide, wide, {2 * kReach + 1, 2 * kReach + 1}, 1.5, 1.5, cv::BORDER_REPLICATE);
  wide.rowRange(kReach, kReach + cells->rows).copyTo(*cells);
}

// Every second pixel and row.
cv::Mat every_second(const cv::Mat& columns) {
  cv::Mat half;
  cv::resize(columns, half, (columns.size() + cv::Size(1, 1)) / 2, 0, 0, cv::INTER_NEAREST);
  return half;
}

cv::Mat median_around(const cv::Mat& columns) {
  constexpr int kReach = 2;
  cv::Mat wide = around_seam(columns, kReach);
  cv::medianBlur(wide, wide, 2 * kReach + 1);
  return wide.rowRange(kReach, kReach + columns.rows).clone();
}

// Fills what is not seen (negative) from around, coarsely. Where nothing at all is seen, everything
// is infinitely far.
void fill_unseen(cv::Mat* columns) {
  const cv::Mat unseen = *columns < 0.0;
  if (cv::countNonZero(unseen) == 0) return;
  cv::Mat rows = every_second(*columns).t();
  if (!fill_unknown(rows < 0.0, Seam::kJoined, {0, rows.rows}, &rows)) rows = 0.0;
  cv::Mat filled;
  cv::resize(rows.t(), filled, columns->size(), 0, 0, cv::INTER_NEAREST);
  filled.copyTo(*columns, unseen);
}

// The inverse distances that most of what is seen around each cell has: medians of medians, of
// every second pixel, then of every second of those.
cv::Mat1f usual_distances(std::span<const float> inverse, PanoramaSize size) {
  static_assert(kCell == 4);
  cv::Mat half =
      every_second(cv::Mat(size.width, size.height, CV_32F, const_cast<float*>(inverse.data())));
  fill_unseen(&half);
  return median_around(every_second(median_around(half)));
}

// The most that any map is trusted in each cell of a view.
cv::Mat1f trust_in_any(const cv::Mat1f& inverse, const EyeCircle& eye,
                       std::span<const TrustedMap> maps) {
  cv::Mat1f trust(inverse.size());
  const Latitudes latitudes(inverse.cols);
  parallel_for(0, inverse.rows, 8, [&](int begin, int end) {
    for (int theta = begin; theta < end; ++theta) {
      const double theta_rad = theta_of_column(theta, inverse.rows);
      const Eigen::Vector3d eye_m = eye.position_m(theta_rad);
      std::fill_n(trust[theta], inverse.cols, 0.0f);
      for (const TrustedMap& map : maps) {
        map.trust->find_most(theta_rad, latitudes,
                             offset_in_column(eye_m - map.position_m, theta_rad), inverse[theta],
                             trust[theta]);
      }
    }
  });
  blur(&trust);
  trust.setTo(1.0, trust > 0.9999);  // up to the rounding of the blur
  return trust;
}

// Interpolates a panorama of cells at the pixels of distances.
cv::Mat1f pixels_of(const cv::Mat1f& cells, PanoramaSize size) {
  cv::Mat1f columns;
  cv::resize(around_seam(cells, 1), columns, {}, kCell, kCell, cv::INTER_LINEAR);
  return columns(cv::Rect(0, kCell, size.height, size.width));
}

}  // namespace

MapTrust::MapTrust(const DistanceVolume& volume, int map) {
  const PanoramaSize size = volume.size();
  cv::Mat1f columns(size.width, size.height);
  for (int theta = 0; theta < size.width; ++theta) {
    std::ranges::transform(volume.distance_column(map, theta), volume.confidence_column(map, theta),
                           columns[theta], trust_of);
  }
  const cv::Size cells((size.height + kCell - 1) / kCell, (size.width + kCell - 1) / kCell);
  cv::resize(columns, cells_, cells, 0, 0, cv::INTER_AREA);
  blur(&cells_);
  std::ranges::transform(cells_, cells_.begin(), trust_of_share);
  everywhere_ = std::ranges::all_of(cells_, [](float trust) { return trust >= 1.0f; });
}

void MapTrust::find_most(double theta_rad, const Latitudes& latitudes, Offset to_eye,
                         const float* inverse, float* trust) const {
  const auto per_turn = static_cast<float>(cells_.rows / kTwoPi);
  const auto per_phi = static_cast<float>(cells_.cols / kPi);
  const auto column = static_cast<float>((theta_rad + kPi) / kTwoPi * cells_.rows - 0.5);
  for (int row = 0; row < latitudes.rows(); ++row) {
    const auto i = static_cast<std::size_t>(row);
    const SeenPoint seen =
        seen_from(latitudes.sin_phi[i], latitudes.cos_phi[i], inverse[row], to_eye);
    const float u = column + seen.turn_rad * per_turn + static_cast<float>(cells_.rows);
    const float v = std::clamp((static_cast<float>(kHalfPi) - seen.phi_rad) * per_phi - 0.5f, 0.0f,
                               static_cast<float>(cells_.cols - 1));
    const int left = static_cast<int>(u), upper = static_cast<int>(v);
    const auto in_column = [&](int theta) {
      const float* const cells = cells_[theta % cells_.rows];
      return std::lerp(cells[upper], cells[std::min(upper + 1, cells_.cols - 1)],
                       v - static_cast<float>(upper));
    };
    const float here =
        std::lerp(in_column(left), in_column(left + 1), u - static_cast<float>(left));
    trust[row] = std::max(trust[row], here);
  }
}

void SmoothDistances::compute(std::span<const float> inverse, PanoramaSize size,
                              const EyeCircle& eye, std::span<const TrustedMap> maps) {
  const cv::Mat1f usual = usual_distances(inverse, size);
  inverse_ = pixels_of(usual, size);
  trust_ = pixels_of(trust_in_any(usual, eye, maps), size);
  unreliable_.clear();
  for (int theta = 0; theta < size.width; ++theta) {
    const float* const column = trust_[theta];
    unreliable_.push_back(
        std::any_of(column, column + size.height, [](float t) { return t < 1.0f; }));
  }
}

void SmoothDistances::smooth(int theta, std::span<float> inverse) const {
  const float* const trust = this->trust(theta);
  if (trust == nullptr) return;
  const float* const smooth = inverse_[theta];
  for (size_t row = 0; row < inverse.size(); ++row) {
    if (trust[row] < 1.0f) inverse[row] = smooth[row] + (inverse[row] - smooth[row]) * trust[row];
  }
}

}  // namespace raywalk
