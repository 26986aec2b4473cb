#include "calibrate/lens/track_point.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

namespace raywalk::calibrate {
namespace {

// An anchor on the ray, with two directions at right angles to it.
TrackPoint anchored_at(const ViewRay& ray) {
  TrackPoint point;
  point.from_m = ray.origin_m;
  point.axis = ray.direction;
  Eigen::Index least = 0;
  ray.direction.cwiseAbs().minCoeff(&least);
  point.right = ray.direction.cross(Eigen::Vector3d::Unit(least)).normalized();
  point.up = ray.direction.cross(point.right);
  return point;
}

}  // namespace

// The cross product of an observed unit direction with the predicted ray is the sine of their angle
// (the predicted ray is near unit length) and linear in the three unknowns.
std::optional<TrackPoint> triangulate(std::span<const ViewRay> rays) {
  TrackPoint point = anchored_at(rays.front());
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  for (const ViewRay& ray : rays) {
    Eigen::Matrix3d slope;
    slope.col(0) = ray.direction.cross(point.right);
    slope.col(1) = ray.direction.cross(point.up);
    slope.col(2) = ray.direction.cross(point.from_m - ray.origin_m);
    normal += slope.transpose() * slope;
    right_side -= slope.transpose() * ray.direction.cross(point.axis);
  }
  // Parallel rays, or rays of one origin, do not determine the distance. A small prior then puts
  // the point at infinity; it is negligible for a parallax of some millimetres.
  constexpr double kPrior_m2 = 1e-8;
  normal(2, 2) += kPrior_m2;
  const Eigen::LDLT<Eigen::Matrix3d> factors(normal);
  point.value = factors.solve(right_side);
  if (factors.info() != Eigen::Success || !point.value.allFinite()) return std::nullopt;
  for (const ViewRay& ray : rays) {
    if (point.ray_from(ray.origin_m).dot(ray.direction) <= 0.0) return std::nullopt;
  }
  return point;
}

}  // namespace raywalk::calibrate
