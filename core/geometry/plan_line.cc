#include "core/geometry/plan_line.h"

#include <cmath>
#include <vector>

#include "core/geometry/position_tolerance.h"
#include "core/geometry/straight_fit.h"

namespace raywalk {

double PlanLine::distance_to(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d from = point - origin;
  return std::abs(direction.x() * from.y() - direction.y() * from.x());
}

// The signed distance is linear, so within a box it differs from that of the centre by no more than
// at a corner.
bool PlanLine::may_come_near(const PlanBox& box, double limit_m) const {
  const Eigen::Vector2d half = 0.5 * (box.high - box.low);
  const Eigen::Vector2d centre = box.low + half;
  const double spread = std::abs(direction.x()) * half.y() + std::abs(direction.y()) * half.x();
  return distance_to(centre) <=
         limit_m + spread + rounding_m(centre.norm() + origin.norm() + half.norm());
}

double PlanLine::obliqueness() const {
  const int u = along_index(axis);
  return std::abs(direction[1 - u]) / direction[u];
}

// The direction (cos t, sin t) that leaves the least squares perpendicular to it is the major axis
// of the scatter matrix [sxx sxz; sxz szz]: tan 2t = 2 sxz / (sxx - szz).
PlanLine fit_line(std::span<const Eigen::Vector2d> points, LineAxis axis) {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) centroid += point - points.front();
  centroid = points.front() + centroid / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : points) {
    scatter += (point - centroid) * (point - centroid).transpose();
  }
  const double angle = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  // Along x the angle is near 0, where the sine is exact for exactly straight lines; along z it is
  // taken from the z axis for the same reason.
  Eigen::Vector2d direction{std::cos(angle), std::sin(angle)};
  if (axis == LineAxis::kZ) {
    const double from_z = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(1, 1) - scatter(0, 0));
    direction = {std::sin(from_z), std::cos(from_z)};
  }
  return {axis, centroid, direction};
}

// The sum of squares is a cosine of twice the angle, so the best allowed angle is the limit on the
// side of the best angle of all.
PlanLine fit_line_within(std::span<const Eigen::Vector2d> points, LineAxis axis,
                         double most_oblique) {
  PlanLine line = fit_line(points, axis);
  if (line.obliqueness() <= most_oblique) return line;
  const int u = along_index(axis);
  line.direction[1 - u] = std::copysign(most_oblique, line.direction[1 - u]);
  line.direction[u] = 1.0;
  line.direction.normalize();
  return line;
}

PlanLine narrowest_line(std::span<const Eigen::Vector2d> points, LineAxis axis,
                        double most_oblique) {
  const int u = along_index(axis);
  std::vector<Eigen::Vector2d> from_first;
  from_first.reserve(points.size());
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d from = point - points.front();
    from_first.emplace_back(from[u], from[1 - u]);
  }
  const Strip strip = narrowest_strip(from_first, most_oblique);
  PlanLine line{.axis = axis, .origin = points.front(), .direction = {0, 0}};
  line.origin[1 - u] += strip.middle;
  line.direction[u] = 1.0;
  line.direction[1 - u] = strip.slope;
  line.direction.normalize();
  return line;
}

}  // namespace raywalk
