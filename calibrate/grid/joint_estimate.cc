#include "calibrate/grid/joint_estimate.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "calibrate/grid/joint_problem.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk::calibrate {
namespace {

using P = RailParameter;

FramePose pose_of(const StationUnknowns& station, const std::optional<FramePose>& solved,
                  const PoseCovariance& covariance) {
  FramePose pose = solved.value_or(FramePose{});
  pose.origin = solved ? PoseOrigin::kSolved : PoseOrigin::kRail;
  pose.position_m = station.position_m;
  pose.world_from_camera = station.attitude();
  pose.position_sigma_mm = 1e3 * std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3.0);
  pose.rotation_sigma_deg =
      degrees_from_radians(std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3.0));
  return pose;
}

// The derivative of every unknown by a small rigid motion of the whole grid (columns: translation
// along x, y, z, then rotation about them at the middle of the grid).
Eigen::MatrixXd common_motions(const CaptureSet& set, const JointInput& input,
                               const JointProblem& problem, const Eigen::Vector3d& middle) {
  // A rotation w moves a point p by w x p = -[p]x w.
  const auto moved_by_turn = [&](const Eigen::Vector3d& position) {
    return cross_matrix(middle - position);
  };
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(problem.columns(), 6);
  for (size_t i = 0; i < set.frames.size(); ++i) {
    auto rows = motions.middleRows<6>(problem.column_of_station(i));
    rows.setIdentity();
    rows.topRightCorner<3, 3>() = moved_by_turn(problem.stations()[i].position_m);
  }
  for (size_t i = 0; i < input.rails.size(); ++i) {
    const RailFrame& frame = input.rails[i].frame;
    auto rows = motions.middleRows<kRigidParameters>(problem.column_of_rail(i));
    rows.topLeftCorner<3, 3>().setIdentity();
    rows.topRightCorner<3, 3>() = moved_by_turn(frame.middle_m);
    rows(P::kHeading, 4) = 1.0;
    // A rotation about z raises the end of a line along x, one about x lowers that of one along z.
    rows(P::kTilt, frame.axis == LineAxis::kX ? 5 : 3) = frame.axis == LineAxis::kX ? 1.0 : -1.0;
    rows.block<3, 3>(P::kRotation, 3).setIdentity();
  }
  return motions;
}

// The gauge constraint: no mean motion of the stations' positions, and, with a small weight, of
// their attitudes, for the rotation that the positions of a single line leave undetermined.
Eigen::MatrixXd gauge_constraint(const CaptureSet& set, const JointProblem& problem,
                                 const Eigen::MatrixXd& motions, double extent_m) {
  constexpr double kAttitudeWeight = 1e-2;
  Eigen::MatrixXd gauge = Eigen::MatrixXd::Zero(motions.rows(), 6);
  for (size_t i = 0; i < set.frames.size(); ++i) {
    const int column = problem.column_of_station(i);
    gauge.middleRows<3>(column) = motions.middleRows<3>(column) / (extent_m * extent_m);
    gauge.middleRows<3>(column + 3) = kAttitudeWeight * motions.middleRows<3>(column + 3);
  }
  return gauge;
}

// Solves with the normal equations to get the covariance of selected combinations of unknowns.
class NormalInverse {
 public:
  // Rows are residuals divided by their standard deviations. An unknown whose column is empty is
  // constant and has zero variance. Unknowns in metres and radians
  // are scaled to unit diagonal first. Throws Error where the unknowns are not determined.
  explicit NormalInverse(const Eigen::SparseMatrix<double>& jacobian)
      : scale_(Eigen::VectorXd::Ones(jacobian.cols())) {
    for (int column = 0; column < jacobian.outerSize(); ++column) {
      const double length = jacobian.col(column).norm();
      held_.push_back(!(length > 0.0));
      if (length > 0.0) scale_[column] = 1.0 / length;
    }
    const Eigen::SparseMatrix<double> scaled = jacobian * scale_.asDiagonal();
    Eigen::SparseMatrix<double> normal = scaled.transpose() * scaled;
    for (int column = 0; column < normal.outerSize(); ++column) {
      if (held_[static_cast<size_t>(column)]) normal.coeffRef(column, column) = 1.0;
    }
    factors_.compute(normal);
    if (factors_.info() != Eigen::Success) {
      throw Error(
          "the estimate's covariance cannot be computed: the normal equations are singular; solve "
          "the poses again");
    }
  }

  // The covariance of linear combinations of the unknowns, the columns of `combinations`.
  Eigen::MatrixXd of(const Eigen::MatrixXd& combinations) const {
    Eigen::MatrixXd scaled = scale_.asDiagonal() * combinations;
    for (Eigen::Index row = 0; row < scaled.rows(); ++row) {
      if (held_[static_cast<size_t>(row)]) scaled.row(row).setZero();
    }
    return scaled.transpose() * factors_.solve(scaled);
  }

 private:
  Eigen::VectorXd scale_;
  std::vector<bool> held_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
};

// Covariances relative to the grid as a whole: the unobservable common motion is removed by an
// S-transformation (Baarda 1973).
class RelativeCovariance {
 public:
  RelativeCovariance(const CaptureSet& set, const JointInput& input, JointProblem* problem)
      : inverse_(problem->jacobian()) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const StationUnknowns& station : problem->stations()) middle += station.position_m;
    middle /= static_cast<double>(problem->stations().size());
    double extent_m = 0.0;
    for (const StationUnknowns& station : problem->stations()) {
      extent_m = std::max(extent_m, (station.position_m - middle).norm());
    }
    motions_ = common_motions(set, input, *problem, middle);
    gauge_ = gauge_constraint(set, *problem, motions_, extent_m > 0.0 ? extent_m : 1.0);
    const Eigen::MatrixXd mean = gauge_.transpose() * motions_;
    gauge_ = gauge_ * mean.inverse().transpose();
  }

  // Covariance of linear combinations of the unknowns, the columns of `combinations`.
  Eigen::MatrixXd of(const Eigen::MatrixXd& combinations) const {
    return inverse_.of(combinations - gauge_ * (motions_.transpose() * combinations));
  }
  Eigen::MatrixXd of_block(int first, int count) const {
    Eigen::MatrixXd picked = Eigen::MatrixXd::Zero(motions_.rows(), count);
    picked.middleRows(first, count).setIdentity();
    return of(picked);
  }

 private:
  NormalInverse inverse_;
  Eigen::MatrixXd motions_;
  Eigen::MatrixXd gauge_;
};

}  // namespace

JointEstimate estimate_jointly(const CaptureSet& set, const JointInput& input,
                               std::span<const RelatedFrames> pairs) {
  JointProblem problem(set, input);
  problem.solve();
  const RelativeCovariance relative(set, input, &problem);
  JointEstimate estimate{.rails = problem.rails()};
  for (size_t rail = 0; rail < input.rails.size(); ++rail) {
    estimate.rail_covariance.emplace_back(
        relative.of_block(problem.column_of_rail(rail), kRigidParameters));
  }
  for (size_t i = 0; i < set.frames.size(); ++i) {
    throw_if_interrupted();
    estimate.covariance.emplace_back(relative.of_block(problem.column_of_station(i), 6));
    estimate.poses.emplace_back(
        pose_of(problem.stations()[i], input.solved[i], estimate.covariance.back()));
  }
  for (const RelatedFrames& pair : pairs) {
    Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(problem.columns(), 6);
    difference.middleRows(problem.column_of_station(static_cast<size_t>(pair.a)), 6).setIdentity();
    difference.middleRows(problem.column_of_station(static_cast<size_t>(pair.b)), 6) -=
        Eigen::MatrixXd::Identity(6, 6);
    estimate.pair_covariance.emplace_back(relative.of(difference));
  }
  return estimate;
}

}  // namespace raywalk::calibrate
