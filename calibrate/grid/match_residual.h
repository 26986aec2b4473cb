// The residual of two rays to one scene point of unknown distance.
//
// Let a ray leave a with direction d_a and another b with d_b. A point at the inverse distance w
// along the first is seen from b in the direction
//   q(w) ~ d_a + w (a - b),
// which moves along the epipolar line by g = (I - d_b d_b^T) (a - b) per unit of w. With w drawn
// from a distribution of mean m and standard deviation s, the difference q(m) - d_b has the
// covariance 2 n^2 I + s^2 g g^T, n being the noise of a direction. Whitened by it, the difference
// has full weight across the epipolar line, and along it a weight limited by the unknown depth. So
// the residual passes smoothly from the epipolar constraint, for a long baseline, to a constraint
// on rotation alone, for a zero baseline, where there is no epipolar line: stations at a crossing
// are coincident or up to some centimetres apart.
//
// The mean m is an unknown of the estimate. If it were fixed, many matches together would determine
// the length of the baseline from it, and its error would bias the length.
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace raywalk::calibrate {

// Distribution of the inverse distances of scene points, 1/m.
struct InverseDepths {
  double mean = 0.0;
  double sigma = 1.0;
};

// Prior of the mean: the scene is about as far away as the lines are long, within a factor of a
// few.
struct MeanDepthPrior {
  double mean = 1.0;
  double sigma = 1.0;

  template <typename T>
  bool operator()(const T* value, T* residual) const {
    residual[0] = (value[0] - mean) / sigma;
    return true;
  }
};
inline MeanDepthPrior mean_depth_prior(double scene_m) { return {1.0 / scene_m, 1.5 / scene_m}; }

// A ray in world axes.
struct WorldRay {
  Eigen::Vector3d origin_m{0, 0, 0};
  Eigen::Vector3d direction{0, 0, 1};  // unit
};

// Maps a difference of directions to its whitened components along (row 0) and across (row 1) the
// epipolar line.
using Whitening = Eigen::Matrix<double, 2, 3>;

inline Whitening whitening_of(const WorldRay& a, const WorldRay& b, const InverseDepths& depth,
                              double noise_rad) {
  const Eigen::Vector3d baseline = a.origin_m - b.origin_m;
  const Eigen::Vector3d along = baseline - b.direction * b.direction.dot(baseline);
  const double length = along.norm();
  // Without a baseline any direction is valid: both components then have the same weight.
  const Eigen::Vector3d first =
      length > 0.0 ? Eigen::Vector3d(along / length) : b.direction.unitOrthogonal();
  const double noise2 = 2.0 * noise_rad * noise_rad;
  Whitening whitening;
  whitening.row(0) = first / std::sqrt(noise2 + std::pow(depth.sigma * length, 2));
  whitening.row(1) = b.direction.cross(first) / std::sqrt(noise2);
  return whitening;
}

// q(m) - d_b, for double or for ceres::Jet.
template <typename T>
Eigen::Matrix<T, 3, 1> direction_difference(const Eigen::Matrix<T, 3, 1>& a_origin,
                                            const Eigen::Matrix<T, 3, 1>& a_direction,
                                            const Eigen::Matrix<T, 3, 1>& b_origin,
                                            const Eigen::Matrix<T, 3, 1>& b_direction,
                                            const T& mean_inverse_distance) {
  const Eigen::Matrix<T, 3, 1> seen = a_direction + mean_inverse_distance * (a_origin - b_origin);
  return seen / seen.norm() - b_direction;
}

template <typename T>
Eigen::Matrix<T, 3, 1> rotated(const T* rotation_vector, const Eigen::Vector3d& vector) {
  const std::array<T, 3> argument{T(vector.x()), T(vector.y()), T(vector.z())};
  Eigen::Matrix<T, 3, 1> result;
  ceres::AngleAxisRotatePoint(rotation_vector, argument.data(), result.data());
  return result;
}

}  // namespace raywalk::calibrate
