// The right-handed world of programs whose z is up: x right, y forward, z up.
#pragma once

#include <Eigen/Core>

namespace raywalk {

// Between Raywalk's world (x right, y up, z forward) and that one; its own inverse.
inline Eigen::Vector3d z_up_axes(const Eigen::Vector3d& point) {
  return {point.x(), point.z(), point.y()};
}

// The same as a matrix. It is a reflection, as Raywalk's world is left-handed.
inline Eigen::Matrix3d z_up_matrix() {
  Eigen::Matrix3d swap;
  swap << 1, 0, 0,  //
      0, 0, 1,      //
      0, 1, 0;
  return swap;
}

}  // namespace raywalk
