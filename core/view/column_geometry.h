// The geometry that all passes of a view share.
//
// Images of a view are indexed [theta][phi], as stations are, so that a column is contiguous. All
// of a column lies in one vertical plane; what is computed for its points is computed in the
// column's frame: ahead (in the plan direction theta), aside (to the right of it), up.
//
// A point is known by its direction r from the eye and its inverse distance w (1/m): it is at
// r / w. Seen from a place S it is in direction r + w (P - S), P being the eye, at inverse distance
// w / |r + w (P - S)|. That holds from w = 0, infinitely far, to the largest floats.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/geometry/fast_math.h"
#include "core/geometry/sphere.h"
#include "core/room/distance_maps.h"
#include "core/view/vector_clones.h"

namespace raywalk {

struct Latitude {
  float sin_phi = 0.0f, cos_phi = 1.0f;
};

// Sine and cosine of the latitudes of a panorama's rows.
struct Latitudes {
  explicit Latitudes(int rows = 0)
      : sin_phi(static_cast<std::size_t>(rows)), cos_phi(static_cast<std::size_t>(rows)) {
    for (int v = 0; v < rows; ++v) {
      const double phi = kHalfPi - (v + 0.5) / rows * kPi;
      sin_phi[static_cast<std::size_t>(v)] = static_cast<float>(std::sin(phi));
      cos_phi[static_cast<std::size_t>(v)] = static_cast<float>(std::cos(phi));
    }
  }
  int rows() const { return static_cast<int>(sin_phi.size()); }
  // The latitude `down` rows, at most some two, below a row's middle; exact to the square of that
  // angle.
  Latitude beside(int row, float down) const {
    const auto i = static_cast<std::size_t>(row);
    const float angle = down * static_cast<float>(kPi) / static_cast<float>(rows());
    return {sin_phi[i] - angle * cos_phi[i], cos_phi[i] + angle * sin_phi[i]};
  }

  std::vector<float> sin_phi, cos_phi;
};

// The plan direction of a column, which need not be whole.
inline double theta_of_column(double u, int width) { return (u + 0.5) / width * kTwoPi - kPi; }

// A displacement in a column's frame, metres.
struct Offset {
  float ahead = 0.0f, aside = 0.0f, up = 0.0f;
};
inline Offset offset_in_column(const Eigen::Vector3d& d_m, double theta_rad) {
  const double s = std::sin(theta_rad), c = std::cos(theta_rad);
  return {static_cast<float>(d_m.x() * s + d_m.z() * c),
          static_cast<float>(d_m.x() * c - d_m.z() * s), static_cast<float>(d_m.y())};
}

// A point as a place sees it.
struct SeenPoint {
  float turn_rad;  // to the right of the column
  float phi_rad;
  float length;  // of r + w (P - S): the inverse distance there is w / length
};

// The point at inverse distance `w` in a row of a column, from a place that is `to_eye` = P - S
// away from the eye.
RAYWALK_INLINE SeenPoint seen_from(float sin_phi, float cos_phi, float w, Offset to_eye) {
  const float ahead = cos_phi + w * to_eye.ahead;
  const float aside = w * to_eye.aside;
  const float up = sin_phi + w * to_eye.up;
  const float plan_squared = ahead * ahead + aside * aside;
  const float plan = std::sqrt(plan_squared);
  return {fast_atan2(aside, ahead), fast_atan2(up, plan),
          std::sqrt(plan_squared + up * up) + 1e-30f};
}

}  // namespace raywalk
