#include "calibrate/poses/pose_accuracy.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "calibrate/poses/point_evidence.h"

namespace raywalk::calibrate {
namespace {

// Fewer do not determine a pose, as a handful of wrong matches may agree by chance.
constexpr int kLeastObservations = 30;
constexpr std::size_t kMostFramesInFull = 500;

// The unknowns: a pose's rotation in radians and its position in units of `unit_m`, so that both
// have the same scale for any size of the capture.
struct Unknowns {
  std::vector<std::size_t> frames{};    // with a pose
  std::vector<std::size_t> index_of{};  // by frame: index into `frames`
  Eigen::Vector3d mean_m{0, 0, 0};
  double unit_m = 1.0;  // root mean square distance from the mean

  Eigen::Index size() const { return 6 * static_cast<Eigen::Index>(frames.size()); }
};

Unknowns unknowns_of(const FramePoses& poses) {
  Unknowns unknowns;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    unknowns.index_of.push_back(unknowns.frames.size());
    if (!poses[i]) continue;
    unknowns.frames.push_back(i);
    unknowns.mean_m += poses[i]->position_m;
  }
  const auto count = static_cast<double>(unknowns.frames.size());
  if (count == 0.0) return unknowns;
  unknowns.mean_m /= count;
  double square_m2 = 0.0;
  for (const std::size_t i : unknowns.frames) {
    square_m2 += (poses[i]->position_m - unknowns.mean_m).squaredNorm() / count;
  }
  if (square_m2 > 0.0) unknowns.unit_m = std::sqrt(square_m2);
  return unknowns;
}

std::vector<PointEvidence> evidence_of(const RefinedPoses& refined, const Unknowns& unknowns) {
  std::vector<std::vector<LinearObservation>> by_point(refined.points.points_m.size());
  for (const PointObservation& one : refined.points.observations) {
    by_point[one.point].push_back(linearised(one, *refined.poses[one.frame],
                                             refined.points.points_m[one.point], refined.noise_px,
                                             unknowns.unit_m));
    by_point[one.point].back().pose = unknowns.index_of[one.frame];
  }
  std::vector<PointEvidence> evidence;
  evidence.reserve(by_point.size());
  for (auto& observations : by_point) evidence.emplace_back(std::move(observations));
  return evidence;
}

// An orthonormal basis of the seven unobservable common motions of all poses.
Eigen::MatrixXd common_motions(const FramePoses& poses, const Unknowns& unknowns) {
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(unknowns.size(), 7);
  Eigen::Index at = 0;
  for (const std::size_t i : unknowns.frames) {
    const Eigen::Vector3d arm = (poses[i]->position_m - unknowns.mean_m) / unknowns.unit_m;
    motions.block<3, 3>(at + 3, 0).setIdentity();
    // A common rotation a: world_from_camera becomes exp(a) R = R exp(R^T a).
    motions.block<3, 3>(at, 3) = poses[i]->world_from_camera.transpose();
    for (int axis = 0; axis < 3; ++axis) {
      motions.block<3, 1>(at + 3, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(arm);
    }
    motions.block<3, 1>(at + 3, 6) = arm;
    at += 6;
  }
  return Eigen::MatrixXd(Eigen::HouseholderQR<Eigen::MatrixXd>(motions).householderQ() *
                         Eigen::MatrixXd::Identity(unknowns.size(), 7));
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
  Vector6 diagonal;
  diagonal << Eigen::Vector3d::Constant(1.0 / (anchor.rotation_rad * anchor.rotation_rad)),
      Eigen::Vector3d::Constant(unit_m * unit_m / (anchor.position_m * anchor.position_m));
  return diagonal.asDiagonal();
}

void set_from_full_matrix(RefinedPoses* refined, const PoseAnchor& anchor,
                          const Unknowns& unknowns) {
  const Eigen::Index size = unknowns.size();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(size, size);  // covariance of the gradients
  for (const PointEvidence& point : evidence_of(*refined, unknowns)) {
    for (std::size_t i = 0; i < point.size(); ++i) {
      for (std::size_t j = 0; j < point.size(); ++j) {
        const auto row = static_cast<Eigen::Index>(6 * point.pose(i));
        const auto column = static_cast<Eigen::Index>(6 * point.pose(j));
        normal.block<6, 6>(row, column) += point.normal(i, j);
        spread.block<6, 6>(row, column) += point.gradient(i) * point.gradient(j).transpose();
      }
    }
  }
  const Matrix6 anchored = anchor_information(anchor, unknowns.unit_m);
  for (Eigen::Index at = 0; at < size; at += 6) normal.block<6, 6>(at, at) += anchored;
  // With a large weight w on the orthonormal basis N of the unobservable motions, (A + w N N^T)^-1
  // is the pseudo-inverse of A plus 1 / w along N: the covariance of a free network.
  const Eigen::MatrixXd motions = common_motions(refined->poses, unknowns);
  const double weight = normal.diagonal().maxCoeff();
  normal.noalias() += weight * motions * motions.transpose();
  const Eigen::MatrixXd inverse = normal.llt().solve(Eigen::MatrixXd::Identity(size, size));
  const double share = curvature_share(refined->errors_px, refined->noise_px);
  const Eigen::MatrixXd half = inverse * spread / (share * share);
  Eigen::Index at = 0;
  for (const std::size_t frame : unknowns.frames) {
    const Matrix6 covariance = half.middleRows<6>(at) * inverse.middleCols<6>(at);
    set_sigma(&*refined->poses[frame], covariance, unknowns.unit_m);
    at += 6;
  }
}

void set_from_blocks(RefinedPoses* refined, const PoseAnchor& anchor, const Unknowns& unknowns) {
  const std::size_t count = unknowns.frames.size();
  std::vector<Matrix6> normal(count, anchor_information(anchor, unknowns.unit_m));
  std::vector<Matrix6> spread(count, Matrix6::Zero());
  for (const PointEvidence& point : evidence_of(*refined, unknowns)) {
    for (std::size_t i = 0; i < point.size(); ++i) {
      normal[point.pose(i)] += point.normal(i, i);
      spread[point.pose(i)] += point.gradient(i) * point.gradient(i).transpose();
    }
  }
  const double share = curvature_share(refined->errors_px, refined->noise_px);
  for (std::size_t i = 0; i < count; ++i) {
    const Matrix6 inverse = normal[i].llt().solve(Matrix6::Identity());
    set_sigma(&*refined->poses[unknowns.frames[i]], inverse * spread[i] * inverse / (share * share),
              unknowns.unit_m);
  }
}

// Keeps the observations, with their errors, of which `keep(observation, error_px)` is true.
template <typename Keep>
void keep_observations(RefinedPoses* refined, const Keep& keep) {
  std::vector<PointObservation> observations;
  std::vector<double> errors_px;
  for (std::size_t i = 0; i < refined->points.observations.size(); ++i) {
    if (!keep(refined->points.observations[i], refined->errors_px[i])) continue;
    observations.push_back(refined->points.observations[i]);
    errors_px.push_back(refined->errors_px[i]);
  }
  refined->points.observations = std::move(observations);
  refined->errors_px = std::move(errors_px);
}

}  // namespace

void settle(RefinedPoses* refined, const PoseAnchor& anchor) {
  keep_observations(refined, [&](const PointObservation& /*one*/, double error_px) {
    return error_px <= refined->inlier_px;
  });
  const std::vector<bool> linked =
      largest_linked_group(refined->poses.size(), refined->points, kLeastSharedPoints);
  for (std::size_t i = 0; i < linked.size(); ++i) {
    std::optional<FramePose>& pose = refined->poses[i];
    if (pose && (!linked[i] || pose->observations < kLeastObservations)) pose.reset();
  }
  keep_observations(refined, [&](const PointObservation& one, double /*error_px*/) {
    return refined->poses[one.frame].has_value();
  });
  if (!refined->points.observations.empty()) set_sigmas(refined, anchor);
}

void set_sigmas(RefinedPoses* refined, const PoseAnchor& anchor) {
  const Unknowns unknowns = unknowns_of(refined->poses);
  if (unknowns.frames.empty()) return;
  if (unknowns.frames.size() <= kMostFramesInFull) {
    set_from_full_matrix(refined, anchor, unknowns);
  } else {
    set_from_blocks(refined, anchor, unknowns);
  }
}

}  // namespace raywalk::calibrate
