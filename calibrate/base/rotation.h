// Rotation matrices: of rotation vectors and back, and the nearest to other matrices; cross
// products.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace raywalk::calibrate {

// Rotation matrix of a rotation vector and back; the angle is in [0, pi].
inline Eigen::Matrix3d matrix_of(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}
inline Eigen::Vector3d vector_of(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

// The rotation nearest to a sum of rotations, or of products `to * from^T` of vectors, in the
// Frobenius norm (Markley 1988; Hartley et al. 2013, "Rotation averaging", section 5.3): with the
// sum = U S V^T it is U diag(1, 1, det) V^T.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& sum);

// The matrix of the cross product: [v]x w = v x w.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return matrix;
}

}  // namespace raywalk::calibrate
