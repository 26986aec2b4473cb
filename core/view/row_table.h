// Sines and cosines of a column's rows, and positions and displacements in a column's own frame.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "core/geometry/panorama_pixels.h"
#include "core/view/column_kernels.h"

namespace raywalk {

// Sines and cosines of latitude of rows spaced as a panorama of `height` rows spaces them, from the
// zenith on, as many as the spans hold.
template <typename Real>
void fill_latitudes(int height, std::span<Real> sin_phi, std::span<Real> cos_phi) {
  for (size_t row = 0; row < sin_phi.size(); ++row) {
    const double phi_rad = kHalfPi - (static_cast<double>(row) + 0.5) / height * kPi;
    sin_phi[row] = static_cast<Real>(std::sin(phi_rad));
    cos_phi[row] = static_cast<Real>(std::cos(phi_rad));
  }
}

// `count` rows spaced as a panorama of `height` rows spaces them, from the zenith on. With
// count = 2 * height the table goes once around the great circle: down the column and, beyond the
// nadir, up the opposite one.
class LatitudeTable {
 public:
  LatitudeTable(int height, int count)
      : sin_phi_(static_cast<size_t>(count)), cos_phi_(static_cast<size_t>(count)) {
    fill_latitudes<float>(height, sin_phi_, cos_phi_);
  }
  RowTable table(int first_row = 0) const {
    return {sin_phi_.data() + first_row, cos_phi_.data() + first_row};
  }

 private:
  std::vector<float> sin_phi_;
  std::vector<float> cos_phi_;
};

// A displacement in a column frame, metres.
struct PreciseOffset {
  double forward = 0.0;
  double up = 0.0;
  double side = 0.0;
};

// A world displacement in the frame of the column at theta: forward, up, to the right.
inline PreciseOffset precise_offset(const Eigen::Vector3d& displacement_m, double theta_rad) {
  const double s = std::sin(theta_rad);
  const double c = std::cos(theta_rad);
  return {displacement_m.x() * s + displacement_m.z() * c, displacement_m.y(),
          displacement_m.x() * c - displacement_m.z() * s};
}
inline ColumnOffset column_offset(const Eigen::Vector3d& displacement_m, double theta_rad) {
  const PreciseOffset offset = precise_offset(displacement_m, theta_rad);
  return {static_cast<float>(offset.forward), static_cast<float>(offset.up),
          static_cast<float>(offset.side)};
}

// A continuous column position split into a whole column in [0, width) and a fraction in [0, 1).
struct ColumnPosition {
  int whole = 0;
  float part = 0.0f;
};
inline ColumnPosition split_column(double u, int width) {
  double whole = std::floor(u);
  double part = u - whole;
  if (part >= 1.0 - 1e-7) {  // avoids reading a neighbour for a rounding error
    whole += 1.0;
    part = 0.0;
  }
  return {wrapped_column(static_cast<int>(whole), width), static_cast<float>(part)};
}

}  // namespace raywalk
