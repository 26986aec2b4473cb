#include "calibrate/poses/refine_poses.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/rotation.h>
#include <ceres/solver.h>
#include <spdlog/spdlog.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "calibrate/base/cauchy_loss.h"
#include "calibrate/base/rotation.h"
#include "calibrate/base/stop_on_interrupt.h"
#include "calibrate/rails/fit_rails.h"
#include "calibrate/rails/rail_cost.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/progress.h"

namespace raywalk::calibrate {
namespace {

constexpr double kInlierWidth = 4.0;     // standard deviations
constexpr double kLeastNoise_px = 1e-3;  // below the rounding of COLMAP's features
constexpr int kPasses = 3;               // of solving and estimating the noise
constexpr int kIterations = 20;

// Two residuals of a pose and a point: the sine of the angle between the predicted and the observed
// bearing, along two axes across the bearing, times kResidualPx_per_rad: pixels for small angles,
// bounded for large ones.
class BearingResidual {
 public:
  BearingResidual(const PointObservation& observation, const Eigen::Matrix3d& reference)
      : camera_from_world_(reference.transpose()),
        centre_m_(observation.centre_m),
        across_(kResidualPx_per_rad * axes_across(observation.bearing)) {}

  template <typename T>
  bool operator()(const T* pose, const T* point, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector> position(pose + 3);
    const Vector seen = camera_from_world_.cast<T>() * (Eigen::Map<const Vector>(point) - position);
    // camera_from_world = exp(w)^T reference^T, and exp(w)^T = exp(-w).
    const Vector back(-pose[0], -pose[1], -pose[2]);
    Vector turned;
    ceres::AngleAxisRotatePoint(back.data(), seen.data(), turned.data());
    turned -= centre_m_.cast<T>();
    Eigen::Map<Eigen::Matrix<T, 2, 1>> out(residual);
    out = across_.cast<T>() * turned / turned.norm();
    return true;
  }

 private:
  Eigen::Matrix3d camera_from_world_;
  Eigen::Vector3d centre_m_;
  Eigen::Matrix<double, 2, 3> across_;
};

struct AnchorResidual {
  Eigen::Vector3d position_m;
  PoseAnchor anchor;

  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    for (int axis = 0; axis < 3; ++axis) {
      residual[axis] = pose[axis] / anchor.rotation_rad;
      residual[3 + axis] = (pose[3 + axis] - position_m[axis]) / anchor.position_m;
    }
    return true;
  }
};

// Ceres owns the cost, which owns the residual.
template <int... kSizes, typename Residual>
ceres::CostFunction* cost_of(Residual residual) {
  return new ceres::AutoDiffCostFunction<Residual, kSizes...>(new Residual(std::move(residual)));
}

FramePoses observed_only(const FramePoses& poses, const SeenPoints& points) {
  FramePoses kept(poses.size());
  for (const PointObservation& one : points.observations) kept[one.frame] = poses[one.frame];
  return kept;
}

std::vector<double> errors_of(const FramePoses& poses, const SeenPoints& points) {
  std::vector<double> errors;
  errors.reserve(points.observations.size());
  for (const PointObservation& one : points.observations) {
    errors.push_back(error_px(one, *poses[one.frame], points.points_m[one.point]));
  }
  return errors;
}

// The robust standard deviation along one axis of two-dimensional errors: their median length
// divided by that of unit noise, sqrt(2 ln 2).
double noise_of(const std::vector<double>& errors_px) {
  return std::max(median(errors_px) / std::sqrt(2.0 * std::log(2.0)), kLeastNoise_px);
}

// Counts the solver's steps, of which there are at most kIterations and the start.
class StepCounter final : public ceres::IterationCallback {
 public:
  explicit StepCounter(Progress* progress) : progress_(progress) {}
  // A solver that needed fewer steps has done them all.
  ~StepCounter() override { progress_->advance(kStepsOfPass - steps_); }
  StepCounter(const StepCounter&) = delete;
  StepCounter& operator=(const StepCounter&) = delete;

  static constexpr int kStepsOfPass = kIterations + 1;

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    if (steps_ < kStepsOfPass) {
      progress_->advance();
      ++steps_;
    }
    return ceres::SOLVER_CONTINUE;
  }

 private:
  Progress* progress_;
  int steps_ = 0;
};

// Solves from `poses` and `points` with a given width of the loss; replaces both.
class PoseAdjustment {
 public:
  PoseAdjustment(FramePoses* poses, SeenPoints* points) : poses_(*poses), points_(*points) {
    parameters_.resize(poses_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (!poses_[i]) continue;
      const Eigen::Vector3d& position = poses_[i]->position_m;
      parameters_[i] = {0.0, 0.0, 0.0, position.x(), position.y(), position.z()};
    }
  }

  void add_observations(double noise_px) {
    // In standard deviations, like the other residuals. The problem takes ownership of the loss,
    // which all blocks share.
    auto* loss = new ceres::ScaledLoss(new ceres::CauchyLoss(kCauchySigmas * noise_px),
                                       1.0 / (noise_px * noise_px), ceres::TAKE_OWNERSHIP);
    for (const PointObservation& one : points_.observations) {
      const BearingResidual residual(one, poses_[one.frame]->world_from_camera);
      problem_.AddResidualBlock(cost_of<2, 6, 3>(residual), loss, parameters_[one.frame].data(),
                                points_.points_m[one.point].data());
    }
  }

  void add_anchors(const FramePoses& anchors, const PoseAnchor& anchor) {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (!poses_[i]) continue;
      problem_.AddResidualBlock(cost_of<6, 6>(AnchorResidual{anchors[i]->position_m, anchor}),
                                nullptr, parameters_[i].data());
    }
  }

  // Those of lines without a pose are left out.
  void add_rails(const CaptureSet& set, std::vector<Rail>* rails) {
    if (rails->empty()) return;
    auto* loss = new ceres::CauchyLoss(kCauchySigmas);  // owned by the problem
    for (std::size_t line = 0; line < rails->size(); ++line) {
      Rail& rail = (*rails)[line];
      if (rail.stations == 0) continue;
      for (const std::size_t frame : set.lines[line].frames) {
        if (!poses_[frame]) continue;
        const RailCost cost(rail, set.rail_m(frame), poses_[frame]->world_from_camera,
                            planned_attitude(set.frames[frame]));
        problem_.AddResidualBlock(cost_of<6, 6, RailParameter::kCount>(cost), loss,
                                  parameters_[frame].data(), rail.parameters.data());
      }
      add_rail_prior(&rail, &problem_);
      rails_.push_back(rail.parameters.data());
    }
  }

  void solve(int threads, Progress* progress) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.max_num_iterations = kIterations;
    options.function_tolerance = 1e-5;
    options.num_threads = std::max(threads, 1);
    options.logging_type = ceres::SILENT;
    StopOnInterrupt stop;
    StepCounter counter(progress);
    options.callbacks = {&stop, &counter};
    // Points are eliminated first: each is seen by few poses.
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (const PointObservation& one : points_.observations) {
      ordering->AddElementToGroup(points_.points_m[one.point].data(), 0);
    }
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (poses_[i]) ordering->AddElementToGroup(parameters_[i].data(), 1);
    }
    for (double* rail : rails_) ordering->AddElementToGroup(rail, 1);
    options.linear_solver_ordering = ordering;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    spdlog::debug("adjustment: {}", summary.BriefReport());
    throw_if_interrupted();
    if (!summary.IsSolutionUsable()) {
      throw Error("the poses cannot be adjusted to what the panoramas see (" +
                  one_line(summary.message) + "); check the pictures of this capture");
    }
    take_over();
  }

 private:
  void take_over() {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (!poses_[i]) continue;
      const PoseParameters& values = parameters_[i];
      const Eigen::Matrix3d turned =
          poses_[i]->world_from_camera * matrix_of({values[0], values[1], values[2]});
      poses_[i]->world_from_camera = Eigen::Quaterniond(turned).normalized().toRotationMatrix();
      poses_[i]->position_m = {values[3], values[4], values[5]};
    }
  }

  FramePoses& poses_;
  SeenPoints& points_;
  std::vector<PoseParameters> parameters_{};
  std::vector<double*> rails_{};  // their parameters
  ceres::Problem problem_{};
};

void set_figures(RefinedPoses* refined) {
  std::vector<double> squares(refined->poses.size(), 0.0);
  for (std::optional<FramePose>& pose : refined->poses) {
    if (!pose) continue;
    pose->observations = 0;
    pose->origin = PoseOrigin::kSolved;
  }
  for (std::size_t i = 0; i < refined->points.observations.size(); ++i) {
    if (refined->errors_px[i] > refined->inlier_px) continue;
    const std::size_t frame = refined->points.observations[i].frame;
    ++refined->poses[frame]->observations;
    squares[frame] += refined->errors_px[i] * refined->errors_px[i];
  }
  for (std::size_t i = 0; i < squares.size(); ++i) {
    std::optional<FramePose>& pose = refined->poses[i];
    if (pose && pose->observations > 0) {
      pose->residual_px = std::sqrt(squares[i] / pose->observations);
    }
  }
}

}  // namespace

RefinedPoses refine_poses(const CaptureSet& set, const FramePoses& start, const SeenPoints& points,
                          const PoseAnchor& anchor, int threads, std::vector<Rail> rails) {
  RefinedPoses refined;
  refined.poses = observed_only(start, points);
  refined.points = points;
  refined.errors_px = errors_of(refined.poses, refined.points);
  if (refined.errors_px.empty()) throw Error("no scene point is seen by any panorama");
  const FramePoses anchors = refined.poses;
  const bool adjusted_before = !rails.empty();
  Progress progress("adjusting poses", kPasses * StepCounter::kStepsOfPass, "steps");
  for (int pass = 0; pass < kPasses; ++pass) {
    const double before_px = noise_of(refined.errors_px);
    PoseAdjustment adjustment(&refined.poses, &refined.points);
    adjustment.add_observations(before_px);
    adjustment.add_anchors(anchors, anchor);
    adjustment.add_rails(set, &rails);
    adjustment.solve(threads, &progress);
    rails = fit_rails(set, refined.poses);
    refined.errors_px = errors_of(refined.poses, refined.points);
    refined.noise_px = noise_of(refined.errors_px);
    // Stops when the noise has converged.
    if ((pass > 0 || adjusted_before) && refined.noise_px > 0.95 * before_px) break;
  }
  refined.inlier_px = kInlierWidth * refined.noise_px;
  set_figures(&refined);
  return refined;
}

}  // namespace raywalk::calibrate
