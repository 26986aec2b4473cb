#include "core/geometry/eye_circle.h"

#include <cmath>

namespace raywalk {

Eigen::Vector3d EyeCircle::position_m(double theta_rad) const {
  if (radius_m == 0.0) return centre_m;
  // To the left of theta is the direction theta - 90 degrees.
  return centre_m + radius_m * Eigen::Vector3d(-std::cos(theta_rad), 0.0, std::sin(theta_rad));
}

PlanPoint EyeCircle::place(double theta_rad) const {
  const Eigen::Vector3d eye_m = position_m(theta_rad);
  return {eye_m.x(), eye_m.z()};
}

// Seen along theta at the plan distance t, a point is t ahead of the centre and the radius to the
// left of it, hence at the plan distance sqrt(t^2 + radius^2) and atan2(radius, t) to the left of
// theta.
std::optional<SphereAngles> EyeCircle::direction_of(const Eigen::Vector3d& from_centre_m) const {
  SphereAngles seen = angles_from_direction(from_centre_m);
  if (radius_m == 0.0) return seen;
  const double plan_m = std::hypot(from_centre_m.x(), from_centre_m.z());
  if (plan_m < std::abs(radius_m)) return std::nullopt;
  const double ahead_m = std::sqrt((plan_m - std::abs(radius_m)) * (plan_m + std::abs(radius_m)));
  seen.theta_rad = wrap_angle(seen.theta_rad + std::atan2(radius_m, ahead_m));
  seen.phi_rad = std::atan2(from_centre_m.y(), ahead_m);
  return seen;
}

}  // namespace raywalk
