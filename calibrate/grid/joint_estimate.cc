#include "calibrate/grid/joint_estimate.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calibrate/base/stop_on_interrupt.h"
#include "calibrate/grid/joint_costs.h"
#include "calibrate/grid/normal_inverse.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"

namespace raywalk::calibrate {
namespace {

using P = RailParameter;

// A station's unknowns: position, and a rotation vector applied to `reference`.
struct StationUnknowns {
  Eigen::Vector3d position_m{0, 0, 0};
  Eigen::Vector3d turn_rad{0, 0, 0};
  Eigen::Matrix3d reference = Eigen::Matrix3d::Identity();

  Eigen::Matrix3d attitude() const { return matrix_of(turn_rad) * reference; }
};

class JointProblem {
 public:
  JointProblem(const CaptureSet& set, const JointInput& input)
      : set_(set), input_(input), problem_(problem_options()) {
    for (const RailStart& rail : input.rails) rails_.push_back(rail.parameters);
    line_errors_.resize(rails_.size());
    stations_.resize(set.frames.size());
    for (size_t i = 0; i < stations_.size(); ++i) start_station(i);
    for (size_t i = 0; i < stations_.size(); ++i) add_station(i);
    for (size_t i = 0; i < rails_.size(); ++i) add_rail(i);
    for (const MatchObservations& crossing : input.crossings) {
      mean_depths_.push_back(crossing.depth.mean);
    }
    for (size_t i = 0; i < mean_depths_.size(); ++i) {
      add_matches(input.crossings[i], &mean_depths_[i]);
    }
  }

  void solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-12;
    options.parameter_tolerance = 1e-12;
    options.num_threads = thread_count();
    options.logging_type = ceres::SILENT;
    StopOnInterrupt stop;
    options.callbacks.push_back(&stop);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    throw_if_interrupted();
    if (!summary.IsSolutionUsable()) {
      throw Error("the lines of the grid cannot be estimated from these poses (" +
                  one_line(summary.message) + "); solve the poses again");
    }
  }

  const std::vector<RailParameters>& rails() const { return rails_; }
  const std::vector<StationUnknowns>& stations() const { return stations_; }

  // First column of a station's or a rail's unknowns in the normal equations.
  int column_of_station(size_t station) const { return static_cast<int>(6 * station); }
  int column_of_rail(size_t rail) const {
    return static_cast<int>(6 * stations_.size() + P::kCount * rail);
  }
  int columns() const {
    return column_of_rail(rails_.size()) +
           static_cast<int>(kLineErrorParameters * line_errors_.size() + mean_depths_.size());
  }

  // Derivatives of all residuals with robust losses applied, in the order of the columns. Constant
  // parameters have zero columns.
  Eigen::SparseMatrix<double> jacobian() {
    ceres::Problem::EvaluateOptions options;
    for (StationUnknowns& station : stations_) {
      options.parameter_blocks.push_back(station.position_m.data());
      options.parameter_blocks.push_back(station.turn_rad.data());
    }
    for (RailParameters& rail : rails_) options.parameter_blocks.push_back(rail.data());
    for (LineError& error : line_errors_) options.parameter_blocks.push_back(error.data());
    for (double& depth : mean_depths_) options.parameter_blocks.push_back(&depth);
    ceres::CRSMatrix rows;
    problem_.Evaluate(options, nullptr, nullptr, nullptr, &rows);
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(rows.values.size());
    const std::vector<int> columns = tangent_columns();
    for (int row = 0; row < rows.num_rows; ++row) {
      for (auto i = static_cast<size_t>(rows.rows[static_cast<size_t>(row)]);
           i < static_cast<size_t>(rows.rows[static_cast<size_t>(row) + 1]); ++i) {
        entries.emplace_back(row, columns[static_cast<size_t>(rows.cols[i])], rows.values[i]);
      }
    }
    Eigen::SparseMatrix<double> matrix(rows.num_rows, this->columns());
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  }

 private:
  using LineError = std::array<double, kLineErrorParameters>;

  static ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  // Our column of each column of Ceres's Jacobian, which omits constant parameters.
  std::vector<int> tangent_columns() const {
    std::vector<int> columns(static_cast<size_t>(column_of_rail(0)));
    std::iota(columns.begin(), columns.end(), 0);
    for (size_t rail = 0; rail < rails_.size(); ++rail) {
      for (int i = 0; i < P::kCount; ++i) {
        if (input_.rails[rail].kept[static_cast<size_t>(i)]) {
          columns.push_back(column_of_rail(rail) + i);
        }
      }
    }
    for (int i = column_of_rail(rails_.size()); i < this->columns(); ++i) columns.push_back(i);
    return columns;
  }

  const RailStart& rail_of(size_t station) const {
    return input_.rails[static_cast<size_t>(set_.frames[station].line)];
  }

  void start_station(size_t i) {
    stations_[i].position_m = input_.start[i]->position_m;
    stations_[i].reference = input_.start[i]->world_from_camera;
  }

  void add_station(size_t i) {
    const RailStart& rail = rail_of(i);
    StationUnknowns& station = stations_[i];
    auto* along = new ceres::AutoDiffCostFunction<RailCost, 6, 3, 3, P::kCount>(
        new RailCost{rail.frame, set_.rail_m(static_cast<int>(i)), rail.jitter,
                     station.reference * planned_attitude(set_.frames[i]).transpose()});
    problem_.AddResidualBlock(along, nullptr, station.position_m.data(), station.turn_rad.data(),
                              rails_[static_cast<size_t>(set_.frames[i].line)].data());
    if (!input_.solved[i]) return;
    const FramePose& solved = *input_.solved[i];
    const double u = rail.frame.u_of(set_.rail_m(static_cast<int>(i)));
    auto* pose = new ceres::AutoDiffCostFunction<SolvedCost, 6, 3, 3, kLineErrorParameters>(
        new SolvedCost{solved, station.reference * solved.world_from_camera.transpose(), u});
    problem_.AddResidualBlock(pose, &solved_loss_, station.position_m.data(),
                              station.turn_rad.data(),
                              line_errors_[static_cast<size_t>(set_.frames[i].line)].data());
  }

  void add_rail(size_t i) {
    const RailStart& rail = input_.rails[i];
    RailPriorCost prior{};
    std::fill_n(prior.weight.begin() + P::kOffset, 3, 1.0 / rail.offset_prior_m);
    std::fill_n(prior.weight.begin() + P::kHeading, 2, 1.0 / rail.direction_prior_rad);
    std::fill_n(prior.weight.begin() + P::kRotation, 3, 1.0 / rail.rotation_prior_rad);
    std::fill_n(prior.weight.begin() + P::kBow, 4, 1.0 / rail.offset_prior_m);
    std::fill_n(prior.weight.begin() + P::kTwist, 6, 1.0 / rail.twist_prior_rad);
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<RailPriorCost, P::kCount, P::kCount>(
                                  new RailPriorCost(prior)),
                              nullptr, rails_[i].data());
    // A zero variance is replaced by a negligible one, as the residual divides by it.
    constexpr double kNone = 1e-9;
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<LineErrorPriorCost, kLineErrorParameters,
                                        kLineErrorParameters>(new LineErrorPriorCost{
            std::max(input_.solved_error.position_m, kNone * rail.frame.half_length_m),
            std::max(input_.solved_error.rotation_rad, kNone)}),
        nullptr, line_errors_[i].data());
    std::vector<int> held;
    for (int j = 0; j < P::kCount; ++j) {
      if (!rail.kept[static_cast<size_t>(j)]) held.push_back(j);
    }
    if (!held.empty()) {
      problem_.SetManifold(rails_[i].data(), new ceres::SubsetManifold(P::kCount, held));
    }
  }

  void add_matches(const MatchObservations& crossing, double* mean_depth) {
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<MeanDepthPrior, 1, 1>(
                                  new MeanDepthPrior(mean_depth_prior(input_.scene_m))),
                              nullptr, mean_depth);
    for (const CrossingMatch& match : crossing.matches) {
      StationUnknowns& x = stations_[static_cast<size_t>(match.frame_x)];
      StationUnknowns& z = stations_[static_cast<size_t>(match.frame_z)];
      const WorldRay from_x = world_ray({x.position_m, x.attitude()}, match.ray_x);
      const WorldRay from_z = world_ray({z.position_m, z.attitude()}, match.ray_z);
      auto* cost = new ceres::AutoDiffCostFunction<MatchCost, 2, 3, 3, 3, 3, 1>(
          new MatchCost{x.reference * match.ray_x.origin_m, x.reference * match.ray_x.bearing,
                        z.reference * match.ray_z.origin_m, z.reference * match.ray_z.bearing,
                        whitening_of(from_x, from_z, crossing.depth, crossing.noise_rad)});
      problem_.AddResidualBlock(cost, &match_loss_, x.position_m.data(), x.turn_rad.data(),
                                z.position_m.data(), z.turn_rad.data(), mean_depth);
    }
  }

  const CaptureSet& set_;
  const JointInput& input_;
  std::vector<RailParameters> rails_;
  std::vector<StationUnknowns> stations_;
  std::vector<LineError> line_errors_;
  std::vector<double> mean_depths_;  // inverse, by crossing
  ceres::CauchyLoss solved_loss_{3.0};
  // A feature has a match with each station of the other line at the crossing.
  ceres::ScaledLoss match_loss_{new ceres::CauchyLoss(2.0), 1.0 / kCrossingStations,
                                ceres::TAKE_OWNERSHIP};
  ceres::Problem problem_;
};

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
    const Eigen::Vector3d p = position - middle;
    Eigen::Matrix3d moved;
    moved << 0, p.z(), -p.y(), -p.z(), 0, p.x(), p.y(), -p.x(), 0;
    return moved;
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
