#include "calibrate/poses/intersection_check.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "calibrate/base/rotation.h"
#include "calibrate/poses/match_pairs.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

// Limits of a disagreement, beyond kCheckSigmas of its uncertainty: half a pixel of a panorama 4096
// wide, and a fiftieth of the stations' spacing (0.5 mm of 25 mm).
constexpr double kRotationLimit_px = 0.5;
constexpr double kMotionLimit_spacings = 0.02;
constexpr double kCheckSigmas = 4.5;
// A check whose own sigma exceeds this many limits would pass everything.
constexpr double kCoarsest = 4.0;
// Of the motion that the points may ask for, in cells and radians: far beyond what a calibrated
// grid has left. It only keeps a motion that the points do not determine from growing.
constexpr double kPriorCells = 0.1;
constexpr double kPrior_rad = 0.1;
constexpr int kSteps = 5;  // of Gauss and Newton

// By frame: whether it belongs to the line and lies within `reach_m` of the intersection.
std::vector<bool> near_stations(const CaptureSet& set, int line, PlanPoint at, double reach_m) {
  const CaptureLine& of = set.lines[line];
  const double at_m = of.axis == LineAxis::kX ? at.x_m : at.z_m;
  std::vector<bool> near(set.frames.size(), false);
  for (const std::size_t frame : of.frames) {
    near[frame] = std::abs(set.rail_m(frame) - at_m) <= reach_m;
  }
  return near;
}

// By point: whether one of the frames sees it.
std::vector<bool> seen_from(const std::vector<bool>& frames, const SeenPoints& points) {
  std::vector<bool> seen(points.points_m.size(), false);
  for (const PointObservation& one : points.observations) {
    if (frames[one.frame]) seen[one.point] = true;
  }
  return seen;
}

bool in_black_patch(const Eigen::Vector3d& direction) {
  constexpr int kPatchesPerFace = 8;
  Eigen::Index axis = 0;
  const double largest = direction.cwiseAbs().maxCoeff(&axis);
  // Equal angles rather than equal lengths of the cube's face.
  const auto patch = [&](Eigen::Index other) {
    const double share = std::atan(direction[other % 3] / largest) / kHalfPi + 0.5;
    return static_cast<int>(std::floor(share * kPatchesPerFace));
  };
  return (patch(axis + 1) + patch(axis + 2)) % 2 == 0;
}

// The lines of an intersection as the check sees them.
struct NearStations {
  std::vector<bool> along_x{}, along_z{};  // by frame
  Eigen::Vector3d pivot_m{0, 0, 0};        // their mean position
};

NearStations near_intersection(const CaptureSet& set, const LineIntersection& intersection,
                               const FramePoses& poses, double reach_m) {
  NearStations near{near_stations(set, intersection.along_x, intersection.at, reach_m),
                    near_stations(set, intersection.along_z, intersection.at, reach_m)};
  double count = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) near.along_x[i] = near.along_z[i] = false;
    if (!near.along_x[i] && !near.along_z[i]) continue;
    near.pivot_m += poses[i]->position_m;
    count += 1.0;
  }
  if (count > 0.0) near.pivot_m /= count;
  return near;
}

// Observations by the near stations, by point, of the points that both lines see.
using Tracks = std::map<std::size_t, std::vector<PointObservation>>;

Tracks common_tracks(const NearStations& near, const SeenPoints& points) {
  const std::vector<bool> by_x = seen_from(near.along_x, points);
  const std::vector<bool> by_z = seen_from(near.along_z, points);
  Tracks tracks;
  for (const PointObservation& one : points.observations) {
    if (!by_x[one.point] || !by_z[one.point]) continue;
    if (near.along_x[one.frame] || near.along_z[one.frame]) tracks[one.point].push_back(one);
  }
  return tracks;
}

// How the pose of a frame of the line along x follows the motion of that line: a rotation a about
// the pivot and a translation t change its rotation vector by R^T a and its position by
// t + a x (position - pivot). Rows as LinearObservation::by_pose, columns t, a.
Matrix6 follows(const FramePose& pose, const Eigen::Vector3d& pivot_m) {
  Matrix6 change = Matrix6::Zero();
  change.topRightCorner<3, 3>() = pose.world_from_camera.transpose();
  change.bottomLeftCorner<3, 3>().setIdentity();
  change.bottomRightCorner<3, 3>() = -cross_matrix(pose.position_m - pivot_m);
  return change;
}

// The normal equations of the motion, and the covariance of their gradient: errors of one point in
// neighbouring panoramas are correlated, so only points are independent (pose_accuracy.h).
struct MotionEquations {
  Matrix6 normal = Matrix6::Zero();
  Matrix6 spread = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();

  void add(const PointEvidence& point, const std::vector<Matrix6>& follow) {
    Vector6 of_point = Vector6::Zero();
    for (std::size_t i = 0; i < point.size(); ++i) {
      of_point += follow[i].transpose() * point.gradient(i);
      for (std::size_t j = 0; j < point.size(); ++j) {
        normal += follow[i].transpose() * point.normal(i, j) * follow[j];
      }
    }
    gradient += of_point;
    spread += of_point * of_point.transpose();
  }
};

// Moves `points_m` to where their observations want them, too.
MotionEquations equations_at(const NearStations& near, const Tracks& tracks,
                             const FramePoses& poses, double noise_px,
                             std::vector<Eigen::Vector3d>* points_m) {
  MotionEquations equations;
  for (const auto& [point, observations] : tracks) {
    Eigen::Vector3d& at_m = (*points_m)[point];
    std::vector<LinearObservation> linear;
    std::vector<Matrix6> follow;
    for (const PointObservation& one : observations) {
      linear.push_back(linearised(one, *poses[one.frame], at_m, noise_px, 1.0));
      follow.push_back(near.along_x[one.frame] ? follows(*poses[one.frame], near.pivot_m)
                                               : Matrix6(Matrix6::Zero()));
    }
    const PointEvidence evidence(std::move(linear));
    at_m += evidence.point_step_m();
    equations.add(evidence, follow);
  }
  return equations;
}

void move_line(const NearStations& near, const Vector6& step, FramePoses* poses) {
  const Eigen::Matrix3d turn = matrix_of(step.tail<3>());
  for (std::size_t i = 0; i < poses->size(); ++i) {
    if (!near.along_x[i]) continue;
    FramePose& pose = *(*poses)[i];
    pose.position_m = near.pivot_m + turn * (pose.position_m - near.pivot_m) + step.head<3>();
    pose.world_from_camera = turn * pose.world_from_camera;
  }
}

// Squares of the median sigmas of both lines' stations there: the motion is that of the poses.
Vector6 pose_variance(const NearStations& near, const FramePoses& poses) {
  Vector6 variance = Vector6::Zero();
  for (const std::vector<bool>& line : {near.along_x, near.along_z}) {
    std::vector<double> position_m, rotation_rad;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (!line[i]) continue;
      position_m.push_back(1e-3 * poses[i]->position_sigma_mm);
      rotation_rad.push_back(radians_from_degrees(poses[i]->rotation_sigma_deg));
    }
    variance.head<3>().array() += std::pow(median(std::move(position_m)), 2);
    variance.tail<3>().array() += std::pow(median(std::move(rotation_rad)), 2);
  }
  return variance;
}

std::vector<double> errors_of(const Tracks& tracks, const FramePoses& poses,
                              const std::vector<Eigen::Vector3d>& points_m) {
  std::vector<double> errors;
  for (const auto& [point, observations] : tracks) {
    for (const PointObservation& one : observations) {
      errors.push_back(error_px(one, *poses[one.frame], points_m[point]));
    }
  }
  return errors;
}

void measure(const NearStations& near, const Tracks& tracks, FramePoses poses, double noise_px,
             double cell_m, std::vector<Eigen::Vector3d> points_m, IntersectionCheck* check) {
  const Vector6 variance = pose_variance(near, poses);
  Vector6 prior;
  prior << Eigen::Vector3d::Constant(std::pow(kPriorCells * cell_m, -2)),
      Eigen::Vector3d::Constant(std::pow(kPrior_rad, -2));
  Vector6 motion = Vector6::Zero();
  MotionEquations equations;
  for (int step = 0; step < kSteps; ++step) {
    equations = equations_at(near, tracks, poses, noise_px, &points_m);
    equations.normal.diagonal() += prior;
    equations.gradient += prior.cwiseProduct(motion);
    const Vector6 change = -equations.normal.ldlt().solve(equations.gradient);
    move_line(near, change, &poses);
    motion += change;
  }
  const Matrix6 inverse = equations.normal.ldlt().solve(Matrix6::Identity());
  const double share = curvature_share(errors_of(tracks, poses, points_m), noise_px);
  // Few points determine the motion, and the fit takes up part of the errors that their spread is
  // measured by: it is no smaller than by independent errors.
  const Matrix6 by_points = inverse * equations.spread * inverse / (share * share);
  const Matrix6 independent = inverse / share;
  check->covariance = by_points.trace() > independent.trace() ? by_points : independent;
  check->covariance.diagonal() += variance;
  check->motion_m = motion.head<3>();
  check->rotation_rad = motion.tail<3>();
}

// In the least certain direction.
double worst_sigma(const Matrix6& covariance, Eigen::Index first) {
  const Eigen::Matrix3d block = covariance.block<3, 3>(first, first);
  return std::sqrt(std::max(0.0, block.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff()));
}

// The Mahalanobis distance of a difference from zero.
double sigmas_from_zero(const Eigen::Vector3d& difference, const Matrix6& covariance,
                        Eigen::Index first) {
  const Eigen::Matrix3d block = covariance.block<3, 3>(first, first);
  return std::sqrt(std::max(0.0, difference.dot(block.ldlt().solve(difference))));
}

}  // namespace

DividedPoints divide_points(const CaptureSet& set, std::span<const LineIntersection> intersections,
                            const SeenPoints& points) {
  const double reach_m = 0.5 * cell_side_m(set, intersections);
  std::vector<bool> held(points.points_m.size(), false);
  for (const LineIntersection& intersection : intersections) {
    const auto seen = [&](int line) {
      return seen_from(near_stations(set, line, intersection.at, reach_m), points);
    };
    const std::vector<bool> by_x = seen(intersection.along_x), by_z = seen(intersection.along_z);
    const Eigen::Vector3d at_m(intersection.at.x_m, 0.0, intersection.at.z_m);
    for (std::size_t i = 0; i < held.size(); ++i) {
      if (by_x[i] && by_z[i] && in_black_patch(points.points_m[i] - at_m)) held[i] = true;
    }
  }
  const std::vector<bool> chosen = held;
  held.flip();
  return {.used = chosen_points(points, held), .held_out = chosen_points(points, chosen)};
}

std::vector<IntersectionCheck> check_intersections(const CaptureSet& set,
                                                   std::span<const LineIntersection> intersections,
                                                   const FramePoses& poses, double noise_px,
                                                   const SeenPoints& held_out) {
  const double cell_m = cell_side_m(set, intersections);
  std::vector<IntersectionCheck> checks;
  for (const LineIntersection& intersection : intersections) {
    IntersectionCheck check{.intersection = intersection};
    const NearStations near = near_intersection(set, intersection, poses, 0.5 * cell_m);
    const Tracks tracks = common_tracks(near, held_out);
    check.points = static_cast<int>(tracks.size());
    if (check.points >= kLeastCheckPoints) {
      measure(near, tracks, poses, noise_px, cell_m, held_out.points_m, &check);
    }
    checks.push_back(check);
  }
  return checks;
}

std::vector<std::string> intersection_faults(const CaptureSet& set, const IntersectionCheck& check,
                                             double spacing_m) {
  const std::string lines = fmt::format("lines {} and {}", set.line_id(check.intersection.along_x),
                                        set.line_id(check.intersection.along_z));
  if (check.points < kLeastCheckPoints) {
    return {fmt::format(
        "{} have only {} held-out scene points in common where they should cross, {} are needed: "
        "they are connected only by other intersections; check that both were captured in this "
        "room "
        "and lie where they were planned",
        lines, check.points, kLeastCheckPoints)};
  }
  std::vector<std::string> faults;
  const double limit_mm = 1e3 * kMotionLimit_spacings * spacing_m;
  const double sigma_mm = 1e3 * worst_sigma(check.covariance, 0);
  const double sigma_px = kResidualPx_per_rad * worst_sigma(check.covariance, 3);
  if (sigma_px > kCoarsest * kRotationLimit_px || sigma_mm > kCoarsest * limit_mm) {
    faults.push_back(fmt::format(
        "{}: held-out points measure their difference only to {:.2g} px and {:.2g} mm, too "
        "coarsely for a check; use larger panoramas, or light and texture the scene better",
        lines, sigma_px, sigma_mm));
  }
  const double rotation_px = kResidualPx_per_rad * check.rotation_rad.norm();
  if (rotation_px > kRotationLimit_px &&
      sigmas_from_zero(check.rotation_rad, check.covariance, 3) > kCheckSigmas) {
    faults.push_back(fmt::format(
        "{}: held-out points show a relative rotation of {:.2f} +- {:.2f} px; look at the "
        "overlays, then solve the poses with more keyframes",
        lines, rotation_px, sigma_px));
  }
  const double motion_mm = 1e3 * check.motion_m.norm();
  if (motion_mm > limit_mm &&
      sigmas_from_zero(check.motion_m, check.covariance, 0) > kCheckSigmas) {
    faults.push_back(fmt::format(
        "{}: held-out points show a relative displacement of {:.2f} +- {:.2f} mm; look at the "
        "overlays, then solve the poses with more keyframes",
        lines, motion_mm, sigma_mm));
  }
  return faults;
}

}  // namespace raywalk::calibrate
