#include "core/geometry/fisheye_lens.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace raywalk {
namespace {

constexpr int kMaxNewtonSteps = 20;

// r / focal_px at the angle t, and its derivative.
struct Radius {
  double value;
  double slope;
};

Radius relative_radius(const FisheyeLens& lens, double t) {
  const double square = t * t;
  const auto& k = lens.k;
  return {fisheye_radius(k, t),
          1.0 + square * (3.0 * k[0] +
                          square * (5.0 * k[1] + square * (7.0 * k[2] + square * 9.0 * k[3])))};
}

// Solves relative_radius(t) = radius by Newton's method, kept inside a bracket that bisection
// narrows: the radius increases with the angle, so there is one root.
double angle_of_radius(const FisheyeLens& lens, double radius) {
  double low = 0.0, high = lens.largest_angle_rad;
  double t = std::min(radius, high);
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const Radius at = relative_radius(lens, t);
    const double error = at.value - radius;
    if (std::abs(error) < 1e-14) break;
    (error > 0.0 ? high : low) = t;
    const double newton = t - error / at.slope;
    t = newton > low && newton < high ? newton : 0.5 * (low + high);
  }
  return t;
}

}  // namespace

void require_monotonic_radius(const FisheyeLens& lens) {
  constexpr int kSteps = 1000;
  for (int i = 0; i <= kSteps; ++i) {
    if (!(relative_radius(lens, lens.largest_angle_rad * i / kSteps).slope > 0.0)) {
      throw Error(
          "the radius of the fisheye lens does not increase with the angle; reduce its "
          "coefficients k or its field of view");
    }
  }
}

std::optional<PixelPosition> project(const FisheyeLens& lens, const Eigen::Vector3d& direction) {
  const double off_axis = std::hypot(direction.x(), direction.y());
  const double t = std::atan2(off_axis, direction.z());
  if (t > lens.largest_angle_rad) return std::nullopt;
  if (off_axis == 0.0) return lens.centre;
  const double radius = lens.focal_px * relative_radius(lens, t).value;
  // v grows downwards, y upwards.
  return PixelPosition{lens.centre.u + radius * direction.x() / off_axis,
                       lens.centre.v - radius * direction.y() / off_axis};
}

std::optional<Eigen::Vector3d> unproject(const FisheyeLens& lens, PixelPosition pixel) {
  const double right = (pixel.u - lens.centre.u) / lens.focal_px;
  const double up = (lens.centre.v - pixel.v) / lens.focal_px;
  const double radius = std::hypot(right, up);
  if (radius > relative_radius(lens, lens.largest_angle_rad).value) return std::nullopt;
  if (radius == 0.0) return Eigen::Vector3d::UnitZ();
  const double t = angle_of_radius(lens, radius), sine = std::sin(t);
  return Eigen::Vector3d(sine * right / radius, sine * up / radius, std::cos(t));
}

DualFisheyeLayout simple_dual_fisheye(PanoramaSize frame) {
  DualFisheyeLayout layout;
  layout.front.focal_px = 0.5 * frame.height * 0.99 / layout.front.largest_angle_rad;
  layout.front.centre = {0.25 * frame.width - 0.5, 0.5 * frame.height - 0.5};
  layout.back = layout.front;
  layout.back.centre.u = 0.75 * frame.width - 0.5;
  return layout;
}

}  // namespace raywalk
