#include "core/geometry/plan_line.h"

namespace raywalk {

// The direction (cos t, sin t) that leaves the least squares perpendicular to it is the major axis
// of the scatter matrix [sxx sxz; sxz szz]: tan 2t = 2 sxz / (sxx - szz). The angle is taken from
// the line's own axis, where the sine is exact for exactly straight lines. The sum of squares is a
// cosine of twice the angle, so the best allowed angle is the limit on the side of the best of all.
PlanLine fit_line(std::span<const Eigen::Vector2d> points, LineAxis axis, double most_oblique) {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) centroid += point - points.front();
  centroid = points.front() + centroid / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : points) {
    scatter += (point - centroid) * (point - centroid).transpose();
  }
  const int u = along_index(axis), v = 1 - u;
  const double angle = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(u, u) - scatter(v, v));
  PlanLine line{.axis = axis, .origin = centroid};
  line.direction[u] = std::cos(angle);
  line.direction[v] = std::sin(angle);
  if (std::abs(line.direction[v]) > most_oblique * line.direction[u]) {
    line.direction[v] = std::copysign(most_oblique, line.direction[v]);
    line.direction[u] = 1.0;
    line.direction.normalize();
  }
  return line;
}

}  // namespace raywalk
