// The joint estimate (joint_estimate.h) as a Ceres problem. Each residual is divided by its
// standard deviation. A station's unknowns are its position and a rotation vector `turn` applied to
// a reference attitude.
#pragma once

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

#include "calibrate/base/stop_on_interrupt.h"
#include "calibrate/grid/joint_estimate.h"
#include "calibrate/grid/match_residual.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"

namespace raywalk::calibrate {

// The rotation vector of exp(turn) * reference * exp(expected)^T, computed with quaternions, whose
// automatic derivatives exist at zero.
template <typename T>
void rotation_difference(const T* turn, const Eigen::Matrix3d& reference, const T* expected,
                         T* difference) {
  T turned[4], middle[4], back[4], product[4], result[4];
  ceres::AngleAxisToQuaternion(turn, turned);
  const Eigen::Quaterniond fixed(reference);
  middle[0] = T(fixed.w());
  middle[1] = T(fixed.x());
  middle[2] = T(fixed.y());
  middle[3] = T(fixed.z());
  const T opposite[3] = {-expected[0], -expected[1], -expected[2]};
  ceres::AngleAxisToQuaternion(opposite, back);
  ceres::QuaternionProduct(turned, middle, product);
  ceres::QuaternionProduct(product, back, result);
  ceres::QuaternionToAngleAxis(result, difference);
}

// A station's deviation from its rail, in the rail's axes.
struct RailCost {
  RailFrame frame;
  double rail_m;
  RailJitter jitter;
  Eigen::Matrix3d turn_reference;  // reference * planned attitude^T

  template <typename T>
  bool operator()(const T* position, const T* turn, const T* rail, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const RailAxes<T> axes =
        rail_axes(frame.axis, rail[RailParameter::kHeading], rail[RailParameter::kTilt]);
    const Vector off = Eigen::Map<const Vector>(position) - rail_position(frame, rail, rail_m);
    residual[0] = off.dot(axes.direction) / jitter.along_m;
    residual[1] = off.dot(axes.across) / jitter.across_m;
    residual[2] = off.dot(axes.up) / jitter.across_m;
    const Vector expected = rail_rotation(frame, rail, rail_m);
    rotation_difference(turn, turn_reference, expected.data(), residual + 3);
    for (int i = 3; i < 6; ++i) residual[i] /= jitter.rotation_rad;
    return true;
  }
};

// The common error of a line's solved poses: position and rotation at its middle, then their
// increase to the end at u = 1.
inline constexpr int kLineErrorParameters = 12;

struct SolvedCost {
  FramePose solved;
  Eigen::Matrix3d turn_reference;  // reference * solved attitude^T
  double u;

  template <typename T>
  bool operator()(const T* position, const T* turn, const T* error, T* residual) const {
    const T none[3] = {T(0), T(0), T(0)};
    rotation_difference(turn, turn_reference, none, residual + 3);
    for (int i = 0; i < 3; ++i) {
      const T moved = error[i] + u * error[6 + i];
      const T turned = error[3 + i] + u * error[9 + i];
      residual[i] =
          (position[i] + moved - solved.position_m[i]) / (1e-3 * solved.position_sigma_mm);
      residual[3 + i] =
          (residual[3 + i] + turned) / radians_from_degrees(solved.rotation_sigma_deg);
    }
    return true;
  }
};

struct LineErrorPriorCost {
  double position_m;
  double rotation_rad;

  template <typename T>
  bool operator()(const T* error, T* residual) const {
    for (int i = 0; i < kLineErrorParameters; ++i) {
      residual[i] = error[i] / (i % 6 < 3 ? position_m : rotation_rad);
    }
    return true;
  }
};

// The residual of match_residual.h as a function of both stations' poses.
struct MatchCost {
  Eigen::Vector3d x_origin, x_bearing, z_origin, z_bearing;  // in the references' world axes
  Whitening whitening;

  template <typename T>
  bool operator()(const T* x_position, const T* x_turn, const T* z_position, const T* z_turn,
                  const T* mean_inverse_distance, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Vector from_x = Eigen::Map<const Vector>(x_position) + rotated(x_turn, x_origin);
    const Vector from_z = Eigen::Map<const Vector>(z_position) + rotated(z_turn, z_origin);
    Eigen::Map<Eigen::Matrix<T, 2, 1>> result(residual);
    result = whitening.cast<T>() * direction_difference<T>(from_x, rotated(x_turn, x_bearing),
                                                           from_z, rotated(z_turn, z_bearing),
                                                           mean_inverse_distance[0]);
    return true;
  }
};

struct RailPriorCost {
  RailParameters weight;  // 1 / sigma

  template <typename T>
  bool operator()(const T* rail, T* residual) const {
    for (size_t i = 0; i < weight.size(); ++i) residual[i] = rail[i] * weight[i];
    return true;
  }
};

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
  using P = RailParameter;
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

}  // namespace raywalk::calibrate
