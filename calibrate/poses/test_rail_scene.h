// For tests: true poses of lines of stations, and scene points around them, without pictures.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/base/rotation.h"
#include "calibrate/base/test_lines.h"
#include "calibrate/poses/refine_poses.h"

namespace raywalk::calibrate {

// Errors of placing rails and stations.
struct RailErrors {
  double line_m = 0.02;
  double line_deg = 1.5;
  double jitter_m = 0.001;
  double jitter_deg = 0.1;
};

inline Eigen::Vector3d random_vector(std::mt19937* random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  const double x = uniform(*random);
  const double y = uniform(*random);
  return {x, y, uniform(*random)};
}

inline Eigen::Matrix3d random_turn(std::mt19937* random, double deg) {
  return matrix_of(random_vector(random, radians_from_degrees(deg)));
}

// Every line rotated and moved as a whole, plus jitter of every station.
inline FramePoses test_truth(const CaptureSet& set, const RailErrors& errors, unsigned seed) {
  std::mt19937 random(seed);
  FramePoses poses = nominal_poses(set);
  for (const CaptureLine& line : set.lines) {
    const Eigen::Matrix3d turn = random_turn(&random, errors.line_deg);
    const Eigen::Vector3d move = random_vector(&random, errors.line_m);
    const Eigen::Vector3d middle = line.axis == LineAxis::kX ? Eigen::Vector3d(0, 0, line.across_m)
                                                             : Eigen::Vector3d(line.across_m, 0, 0);
    for (const int frame : line.frames) {
      FramePose& pose = *poses[frame];
      pose.position_m = turn * (pose.position_m - middle) + middle + move +
                        random_vector(&random, errors.jitter_m);
      pose.world_from_camera =
          turn * pose.world_from_camera * random_turn(&random, errors.jitter_deg);
    }
  }
  return poses;
}

// Points 1.5 to 4 cells away in all directions, each seen by eight stations with normal errors of
// `noise_px` (panorama 4096 wide) along each of two axes.
inline SeenPoints test_points(const CaptureSet& set, const FramePoses& truth, std::size_t count,
                              double scale, double noise_px, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, noise_px / kResidualPx_per_rad);
  std::uniform_real_distribution<double> distance(1.5, 4.0);
  std::uniform_int_distribution<int> first(0, static_cast<int>(set.frames.size()) - 1);
  SeenPoints seen;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d point =
        scale * distance(random) * random_vector(&random, 1.0).normalized();
    seen.points_m.push_back(point);
    const int start = first(random);
    for (int k = 0; k < 8; ++k) {
      // A third of the frames of the run are of other lines, as at intersections.
      const std::size_t frame = (start + (k % 3 == 2 ? 7 * k : k)) % set.frames.size();
      const auto& pose = truth[frame];
      if (!pose) continue;
      const Eigen::Vector3d bearing =
          (pose->world_from_camera.transpose() * (point - pose->position_m)).normalized();
      const Eigen::Vector3d across = bearing.unitOrthogonal();
      const double a = noise(random);
      const double b = noise(random);
      seen.observations.push_back(
          {frame, i, (bearing + a * across + b * bearing.cross(across)).normalized(), {0, 0, 0}});
    }
  }
  return seen;
}

}  // namespace raywalk::calibrate
