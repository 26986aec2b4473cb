#include "calibrate/poses/pose_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <array>
#include <cmath>

#include "calibrate/base/cauchy_loss.h"

namespace raywalk::calibrate {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix63 = Eigen::Matrix<double, 6, 3>;

constexpr int kMostFramesInFull = 500;

// The residual and Jacobians of an observation, in standard deviations.
struct LinearObservation {
  int column = 0;  // of the pose's six in the normal equations
  Eigen::Matrix<double, 2, 6> by_pose{};
  Eigen::Matrix<double, 2, 3> by_point{};
  Eigen::Vector2d error{};
};

// The unknowns: a pose's rotation in radians and its position in units of `unit_m`, so that both
// have the same scale for any size of the capture.
struct Unknowns {
  std::vector<int> columns{};  // of each posed frame in the normal equations; -1 for others
  int size = 0;
  Eigen::Vector3d mean_m{0, 0, 0};
  double unit_m = 1.0;  // root mean square distance from the mean
};

Unknowns unknowns_of(const FramePoses& poses) {
  Unknowns unknowns;
  int count = 0;
  for (const std::optional<FramePose>& pose : poses) {
    unknowns.columns.push_back(pose ? 6 * count : -1);
    if (!pose) continue;
    ++count;
    unknowns.mean_m += pose->position_m;
  }
  unknowns.size = 6 * count;
  if (count == 0) return unknowns;
  unknowns.mean_m /= count;
  double square_m2 = 0.0;
  for (const std::optional<FramePose>& pose : poses) {
    if (pose) square_m2 += (pose->position_m - unknowns.mean_m).squaredNorm() / count;
  }
  if (square_m2 > 0.0) unknowns.unit_m = std::sqrt(square_m2);
  return unknowns;
}

LinearObservation linearised(const RefinedPoses& refined, const Unknowns& unknowns,
                             std::size_t index) {
  const PointObservation& observation = refined.points.observations[index];
  const FramePose& pose = *refined.poses[static_cast<std::size_t>(observation.frame)];
  const std::array<double, 6> at{
      0.0, 0.0, 0.0, pose.position_m.x(), pose.position_m.y(), pose.position_m.z()};
  const auto point = static_cast<std::size_t>(observation.point);
  const std::array<const double*, 2> parameters{at.data(), refined.points.points_m[point].data()};
  // Ceres writes Jacobians row by row.
  Eigen::Matrix<double, 2, 6, Eigen::RowMajor> by_pose;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
  std::array<double*, 2> jacobians{by_pose.data(), by_point.data()};
  Eigen::Vector2d error;
  bearing_cost(observation, pose.world_from_camera)
      ->Evaluate(parameters.data(), error.data(), jacobians.data());
  // The Cauchy loss weights an error e by 1 / (1 + (e / width)^2).
  const double share = refined.errors_px[index] / (kCauchySigmas * refined.noise_px);
  const double scale = 1.0 / (refined.noise_px * std::sqrt(1.0 + share * share));
  by_pose.rightCols<3>() *= unknowns.unit_m;
  const int column = unknowns.columns[static_cast<std::size_t>(observation.frame)];
  return {column, scale * by_pose, scale * by_point, scale * error};
}

std::vector<std::vector<LinearObservation>> by_point(const RefinedPoses& refined,
                                                     const Unknowns& unknowns) {
  std::vector<std::vector<LinearObservation>> observations(refined.points.points_m.size());
  for (std::size_t i = 0; i < refined.points.observations.size(); ++i) {
    const PointObservation& observation = refined.points.observations[i];
    observations[static_cast<std::size_t>(observation.point)].push_back(
        linearised(refined, unknowns, i));
  }
  return observations;
}

// The contribution of a point's observations to the normal equations of the poses and their right
// side, after eliminating the point (Schur complement): one element per observation.
struct PointEvidence {
  std::vector<Matrix63> mixed{};      // pose by point
  std::vector<Matrix63> explained{};  // mixed, times the inverse of the point's own block
  std::vector<Vector6> pull{};
};

PointEvidence evidence_of(const std::vector<LinearObservation>& observations) {
  Eigen::Matrix3d of_point = Eigen::Matrix3d::Zero();
  Eigen::Vector3d point_pull(0, 0, 0);
  for (const LinearObservation& one : observations) {
    of_point += one.by_point.transpose() * one.by_point;
    point_pull += one.by_point.transpose() * one.error;
  }
  // For a point so far away that its distance is undetermined.
  of_point += 1e-12 * of_point.trace() * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d inverse = of_point.inverse();
  PointEvidence evidence;
  for (const LinearObservation& one : observations) {
    evidence.mixed.push_back(one.by_pose.transpose() * one.by_point);
    evidence.explained.push_back(evidence.mixed.back() * inverse);
    evidence.pull.push_back(one.by_pose.transpose() * one.error -
                            evidence.explained.back() * point_pull);
  }
  return evidence;
}

// The matrix of the normal equations of the poses, and the covariance of its right side.
struct PoseEquations {
  Eigen::MatrixXd normal{};
  Eigen::MatrixXd spread{};
};

void add_point(const std::vector<LinearObservation>& observations, PoseEquations* equations) {
  const PointEvidence evidence = evidence_of(observations);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const int row = observations[i].column;
    equations->normal.block<6, 6>(row, row) +=
        observations[i].by_pose.transpose() * observations[i].by_pose;
    for (std::size_t j = 0; j < observations.size(); ++j) {
      const int column = observations[j].column;
      equations->normal.block<6, 6>(row, column) -=
          evidence.explained[i] * evidence.mixed[j].transpose();
      equations->spread.block<6, 6>(row, column) += evidence.pull[i] * evidence.pull[j].transpose();
    }
  }
}

// An orthonormal basis of the seven unobservable common motions of all poses.
Eigen::MatrixXd common_motions(const FramePoses& poses, const Unknowns& unknowns) {
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(unknowns.size, 7);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    const int at = unknowns.columns[i];
    const Eigen::Vector3d arm = (poses[i]->position_m - unknowns.mean_m) / unknowns.unit_m;
    motions.block<3, 3>(at + 3, 0).setIdentity();
    // A common rotation a: world_from_camera becomes exp(a) R = R exp(R^T a).
    motions.block<3, 3>(at, 3) = poses[i]->world_from_camera.transpose();
    for (int axis = 0; axis < 3; ++axis) {
      motions.block<3, 1>(at + 3, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(arm);
    }
    motions.block<3, 1>(at + 3, 6) = arm;
  }
  return Eigen::MatrixXd(Eigen::HouseholderQR<Eigen::MatrixXd>(motions).householderQ() *
                         Eigen::MatrixXd::Identity(unknowns.size, 7));
}

double root_mean_of_diagonal(const Eigen::Ref<const Eigen::Matrix3d>& covariance) {
  return std::sqrt(std::max(covariance.trace() / 3.0, 0.0));
}

void set_sigma(FramePose* pose, const Matrix6& covariance, double unit_m) {
  pose->rotation_sigma_deg =
      degrees_from_radians(root_mean_of_diagonal(covariance.topLeftCorner<3, 3>()));
  pose->position_sigma_mm =
      1e3 * unit_m * root_mean_of_diagonal(covariance.bottomRightCorner<3, 3>());
}

Matrix6 anchor_information(const PoseAnchor& anchor, double unit_m) {
  Eigen::Matrix<double, 6, 1> diagonal;
  diagonal << Eigen::Vector3d::Constant(1.0 / (anchor.rotation_rad * anchor.rotation_rad)),
      Eigen::Vector3d::Constant(unit_m * unit_m / (anchor.position_m * anchor.position_m));
  return diagonal.asDiagonal();
}

// The factor by which the weights overstate the information of the observations. The information is
// the curvature of the loss: w^2 (1 - (e / c)^2) along an error e and w across it, with the weight
// w = 1 / (1 + (e / c)^2). The factor is the mean of both over the mean weight (Huber 1981, section
// 7.6).
double curvature_share(const RefinedPoses& refined) {
  double curvature = 0.0;
  double weights = 0.0;
  for (const double error_px : refined.errors_px) {
    const double share = error_px / (kCauchySigmas * refined.noise_px);
    const double weight = 1.0 / (1.0 + share * share);
    curvature += 0.5 * (weight + weight * weight * (1.0 - share * share));
    weights += weight;
  }
  return curvature / weights;
}

void set_from_full_matrix(RefinedPoses* refined, const PoseAnchor& anchor,
                          const Unknowns& unknowns) {
  PoseEquations equations{Eigen::MatrixXd::Zero(unknowns.size, unknowns.size),
                          Eigen::MatrixXd::Zero(unknowns.size, unknowns.size)};
  for (const auto& observations : by_point(*refined, unknowns)) add_point(observations, &equations);
  Eigen::MatrixXd& normal = equations.normal;
  const Matrix6 anchored = anchor_information(anchor, unknowns.unit_m);
  for (int at = 0; at < unknowns.size; at += 6) normal.block<6, 6>(at, at) += anchored;
  // With a large weight w on the orthonormal basis N of the unobservable motions, (A + w N N^T)^-1
  // is the pseudo-inverse of A plus 1 / w along N: the covariance of a free network.
  const Eigen::MatrixXd motions = common_motions(refined->poses, unknowns);
  const double weight = normal.diagonal().maxCoeff();
  normal.noalias() += weight * motions * motions.transpose();
  const Eigen::MatrixXd inverse =
      normal.llt().solve(Eigen::MatrixXd::Identity(unknowns.size, unknowns.size));
  const double share = curvature_share(*refined);
  const Eigen::MatrixXd half = inverse * equations.spread / (share * share);
  for (std::size_t i = 0; i < unknowns.columns.size(); ++i) {
    const int at = unknowns.columns[i];
    if (at < 0) continue;
    const Matrix6 covariance = half.middleRows<6>(at) * inverse.middleCols<6>(at);
    set_sigma(&*refined->poses[i], covariance, unknowns.unit_m);
  }
}

void set_from_blocks(RefinedPoses* refined, const PoseAnchor& anchor, const Unknowns& unknowns) {
  const auto frames = static_cast<std::size_t>(unknowns.size / 6);
  std::vector<Matrix6> normal(frames, anchor_information(anchor, unknowns.unit_m));
  std::vector<Matrix6> spread(frames, Matrix6::Zero());
  for (const auto& observations : by_point(*refined, unknowns)) {
    const PointEvidence evidence = evidence_of(observations);
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const auto frame = static_cast<std::size_t>(observations[i].column / 6);
      normal[frame] += observations[i].by_pose.transpose() * observations[i].by_pose -
                       evidence.explained[i] * evidence.mixed[i].transpose();
      spread[frame] += evidence.pull[i] * evidence.pull[i].transpose();
    }
  }
  const double share = curvature_share(*refined);
  for (std::size_t i = 0; i < unknowns.columns.size(); ++i) {
    if (unknowns.columns[i] < 0) continue;
    const auto frame = static_cast<std::size_t>(unknowns.columns[i] / 6);
    const Matrix6 inverse = normal[frame].llt().solve(Matrix6::Identity());
    set_sigma(&*refined->poses[i], inverse * spread[frame] * inverse / (share * share),
              unknowns.unit_m);
  }
}

}  // namespace

void set_sigmas(RefinedPoses* refined, const PoseAnchor& anchor) {
  const Unknowns unknowns = unknowns_of(refined->poses);
  if (unknowns.size == 0) return;
  if (unknowns.size / 6 <= kMostFramesInFull) {
    set_from_full_matrix(refined, anchor, unknowns);
  } else {
    set_from_blocks(refined, anchor, unknowns);
  }
}

}  // namespace raywalk::calibrate
