// Directions of a panorama's pixels in single precision, and back.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/geometry/fast_math.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {

// Nearest-pixel lookup is off by up to half a pixel. On a surface at 80 degrees incidence the
// inverse distance changes by this share per radian.
inline const float kSlant = static_cast<float>(std::tan(radians_from_degrees(80.0)));

// Shares of a turn and a half turn per radian; a product is faster than a quotient.
inline constexpr float kPerTurn = static_cast<float>(1.0 / kTwoPi);
inline constexpr float kPerHalfTurn = static_cast<float>(1.0 / kPi);

// Unit directions of a panorama's pixels.
class PixelDirections {
 public:
  explicit PixelDirections(PanoramaSize size) {
    for (int u = 0; u < size.width; ++u) {
      const double theta = angles_from_pixel({double(u), 0.0}, size).theta_rad;
      sin_theta_.push_back(static_cast<float>(std::sin(theta)));
      cos_theta_.push_back(static_cast<float>(std::cos(theta)));
    }
    for (int v = 0; v < size.height; ++v) {
      const double phi = angles_from_pixel({0.0, double(v)}, size).phi_rad;
      sin_phi_.push_back(static_cast<float>(std::sin(phi)));
      cos_phi_.push_back(static_cast<float>(std::cos(phi)));
    }
  }
  Eigen::Vector3f of(int theta, int phi) const {
    const auto t = static_cast<size_t>(theta);
    const auto p = static_cast<size_t>(phi);
    return {cos_phi_[p] * sin_theta_[t], sin_phi_[p], cos_phi_[p] * cos_theta_[t]};
  }
  // Cosine of the latitude of a row: the width of its pixels relative to those at the horizon.
  float cos_phi(int phi) const { return cos_phi_[static_cast<size_t>(phi)]; }
  // The direction in which theta grows, at any latitude.
  Eigen::Vector3f east(int theta) const {
    const auto t = static_cast<size_t>(theta);
    return {cos_theta_[t], 0.0f, -sin_theta_[t]};
  }

 private:
  std::vector<float> sin_theta_, cos_theta_, sin_phi_, cos_phi_;
};

// The pixel of a direction vector of any length.
inline size_t pixel_of(const Eigen::Vector3f& direction, PanoramaSize size) {
  const float plan = std::sqrt(direction.x() * direction.x() + direction.z() * direction.z());
  const float u =
      (fast_atan2(direction.x(), direction.z()) * kPerTurn + 0.5f) * static_cast<float>(size.width);
  const float v =
      (0.5f - fast_atan2(direction.y(), plan) * kPerHalfTurn) * static_cast<float>(size.height);
  return pixel_index(std::clamp(static_cast<int>(u), 0, size.width - 1),
                     std::clamp(static_cast<int>(v), 0, size.height - 1), size);
}

}  // namespace raywalk::build_lf
