#include "calibrate/poses/refine_poses.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <spdlog/spdlog.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <set>

#include "calibrate/base/cauchy_loss.h"
#include "calibrate/base/rotation.h"
#include "calibrate/base/stop_on_interrupt.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/progress.h"
#include "core/geometry/line_gaps.h"

namespace raywalk::calibrate {
namespace {

constexpr double kInlierWidth = 4.0;     // standard deviations
constexpr double kLeastNoise_px = 1e-3;  // below the rounding of COLMAP's features
constexpr int kPasses = 3;               // of solving and estimating the noise
constexpr int kIterations = 20;
// Lower bound of the relative sigma of the slider's distances.
constexpr double kLeastRailSpread = 1e-3;

// Rotation vector and position of a frame, in the order of bearing_cost.
using PoseParameters = std::array<double, 6>;

class AnchorResidual {
 public:
  AnchorResidual(const Eigen::Vector3d& position_m, const PoseAnchor& anchor)
      : position_m_(position_m), anchor_(anchor) {}

  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    for (int axis = 0; axis < 3; ++axis) {
      residual[axis] = pose[axis] / anchor_.rotation_rad;
      residual[3 + axis] = (pose[3 + axis] - position_m_[axis]) / anchor_.position_m;
    }
    return true;
  }

 private:
  Eigen::Vector3d position_m_;
  PoseAnchor anchor_;
};

// The distance of two stations against the slider's.
class RailResidual {
 public:
  RailResidual(double distance_m, double sigma_m) : distance_m_(distance_m), sigma_m_(sigma_m) {}

  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using std::sqrt;
    const T x = b[3] - a[3];
    const T y = b[4] - a[4];
    const T z = b[5] - a[5];
    residual[0] = (sqrt(x * x + y * y + z * z) - distance_m_) / sigma_m_;
    return true;
  }

 private:
  double distance_m_;
  double sigma_m_;
};

// Neighbouring stations on a rail that both have a pose, and their nominal distance. Its error
// grows with `scale_m`, the distance or, if this is larger, the stations' spacing: what stations of
// two passes are off does not shrink with the distance between them.
struct RailStep {
  std::size_t a = 0;
  std::size_t b = 0;
  double distance_m = 0.0;
  double scale_m = 0.0;
};

void set_scales(std::vector<RailStep>* steps) {
  std::vector<double> distances_m;
  for (const RailStep& step : *steps) distances_m.push_back(step.distance_m);
  if (distances_m.empty()) return;
  const double spacing_m = covering_spacing(std::move(distances_m));
  for (RailStep& step : *steps) step.scale_m = std::max(step.distance_m, spacing_m);
}

std::vector<RailStep> rail_steps(const CaptureSet& set, const FramePoses& poses) {
  std::vector<RailStep> steps;
  for (const CaptureLine& line : set.lines) {
    std::optional<int> last;
    for (const int frame : line.frames) {
      if (!poses[static_cast<std::size_t>(frame)]) continue;
      if (last) {
        const double distance_m = set.nominal_distance_m(frame, *last);
        if (distance_m > 0.0) {
          steps.push_back(
              {static_cast<std::size_t>(*last), static_cast<std::size_t>(frame), distance_m});
        }
      }
      last = frame;
    }
  }
  set_scales(&steps);
  return steps;
}

// Relative spread of the poses' distances about the slider's: the carriage rocks, so the feedback
// is less accurate than its resolution.
double rail_spread(const std::vector<RailStep>& steps, const FramePoses& poses) {
  std::vector<double> deviations;
  for (const RailStep& step : steps) {
    const double distance_m = (poses[step.b]->position_m - poses[step.a]->position_m).norm();
    deviations.push_back(std::abs(distance_m - step.distance_m) / step.scale_m);
  }
  return deviations.empty() ? kLeastRailSpread
                            : std::max(kLeastRailSpread, robust_sigma(std::move(deviations)));
}

FramePoses observed_only(const FramePoses& poses, const SeenPoints& points) {
  std::vector<bool> observed(poses.size(), false);
  for (const PointObservation& observation : points.observations) {
    observed[static_cast<std::size_t>(observation.frame)] = true;
  }
  FramePoses kept = poses;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!observed[i]) kept[i].reset();
  }
  return kept;
}

std::vector<double> errors_of(const FramePoses& poses, const SeenPoints& points) {
  std::vector<double> errors;
  errors.reserve(points.observations.size());
  for (const PointObservation& observation : points.observations) {
    const FramePose& pose = *poses[static_cast<std::size_t>(observation.frame)];
    errors.push_back(
        bearing_error_px(observation, pose.world_from_camera, pose.position_m,
                         points.points_m[static_cast<std::size_t>(observation.point)]));
  }
  return errors;
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
    if (steps_ < kStepsOfPass) progress_->advance();
    if (steps_ < kStepsOfPass) ++steps_;
    return ceres::SOLVER_CONTINUE;
  }

 private:
  Progress* progress_;
  int steps_ = 0;
};

// Solves from `poses` and `points` with a given width of the loss; replaces both.
class Adjustment {
 public:
  Adjustment(FramePoses* poses, SeenPoints* points) : poses_(*poses), points_(*points) {
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
    auto cauchy = std::make_unique<ceres::CauchyLoss>(kCauchySigmas * noise_px);
    auto* loss =
        new ceres::ScaledLoss(cauchy.release(), 1.0 / (noise_px * noise_px), ceres::TAKE_OWNERSHIP);
    for (const PointObservation& observation : points_.observations) {
      const auto frame = static_cast<std::size_t>(observation.frame);
      problem_.AddResidualBlock(
          bearing_cost(observation, poses_[frame]->world_from_camera).release(), loss,
          parameters_[frame].data(), point(observation.point));
    }
  }

  void add_anchors(const FramePoses& anchors, const PoseAnchor& anchor) {
    using Cost = ceres::AutoDiffCostFunction<AnchorResidual, 6, 6>;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (!poses_[i]) continue;
      auto cost = std::make_unique<Cost>(
          std::make_unique<AnchorResidual>(anchors[i]->position_m, anchor).release());
      problem_.AddResidualBlock(cost.release(), nullptr, parameters_[i].data());
    }
  }

  void add_rail(const std::vector<RailStep>& steps, double spread) {
    using Cost = ceres::AutoDiffCostFunction<RailResidual, 1, 6, 6>;
    for (const RailStep& step : steps) {
      auto cost = std::make_unique<Cost>(
          std::make_unique<RailResidual>(step.distance_m, spread * step.scale_m).release());
      problem_.AddResidualBlock(cost.release(), nullptr, parameters_[step.a].data(),
                                parameters_[step.b].data());
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
    for (const PointObservation& observation : points_.observations) {
      ordering->AddElementToGroup(point(observation.point), 0);
    }
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (poses_[i]) ordering->AddElementToGroup(parameters_[i].data(), 1);
    }
    options.linear_solver_ordering = ordering;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    spdlog::debug("adjustment: {}", summary.BriefReport());
    throw_if_interrupted();
    if (!summary.IsSolutionUsable()) {
      throw Error("the poses cannot be adjusted to what the panoramas see (" +
                  one_line(summary.message) +
                  "); check the pictures of this capture, or use --method rotation");
    }
    take_over();
  }

 private:
  double* point(int index) { return points_.points_m[static_cast<std::size_t>(index)].data(); }

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
  ceres::Problem problem_{};
};

SeenPoints chosen_points(const SeenPoints& points, const std::vector<bool>& keep) {
  SeenPoints kept;
  std::vector<int> index(points.points_m.size(), -1);
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    index[i] = static_cast<int>(kept.points_m.size());
    kept.points_m.push_back(points.points_m[i]);
  }
  for (PointObservation observation : points.observations) {
    observation.point = index[static_cast<std::size_t>(observation.point)];
    if (observation.point >= 0) kept.observations.push_back(observation);
  }
  return kept;
}

void set_figures(RefinedPoses* refined) {
  std::vector<double> squares(refined->poses.size(), 0.0);
  for (std::optional<FramePose>& pose : refined->poses) {
    if (!pose) continue;
    pose->observations = 0;
    pose->origin = PoseOrigin::kSolved;
  }
  for (std::size_t i = 0; i < refined->points.observations.size(); ++i) {
    if (refined->errors_px[i] > refined->inlier_px) continue;
    const auto frame = static_cast<std::size_t>(refined->points.observations[i].frame);
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

SeenPoints widely_seen(const SeenPoints& points, int least_frames) {
  std::vector<std::set<int>> seen_by(points.points_m.size());
  for (const PointObservation& observation : points.observations) {
    seen_by[static_cast<std::size_t>(observation.point)].insert(observation.frame);
  }
  std::vector<bool> keep;
  keep.reserve(seen_by.size());
  for (const std::set<int>& frames : seen_by) {
    keep.push_back(static_cast<int>(frames.size()) >= least_frames);
  }
  return chosen_points(points, keep);
}

SeenPoints strongest(const SeenPoints& points, int per_frame) {
  std::vector<std::vector<int>> frames(points.points_m.size());
  int frame_count = 0;
  for (const PointObservation& observation : points.observations) {
    frames[static_cast<std::size_t>(observation.point)].push_back(observation.frame);
    frame_count = std::max(frame_count, observation.frame + 1);
  }
  std::vector<std::size_t> order(frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return frames[a].size() > frames[b].size();
  });
  std::vector<int> seen(static_cast<std::size_t>(frame_count), 0);
  std::vector<bool> keep(frames.size(), false);
  for (const std::size_t point : order) {
    const auto& of_point = frames[point];
    keep[point] = std::any_of(of_point.begin(), of_point.end(), [&](int frame) {
      return seen[static_cast<std::size_t>(frame)] < per_frame;
    });
    if (!keep[point]) continue;
    for (const int frame : of_point) ++seen[static_cast<std::size_t>(frame)];
  }
  return chosen_points(points, keep);
}

double noise_of(const std::vector<double>& errors_px) {
  return errors_px.empty() ? 0.0 : median(errors_px) / std::sqrt(2.0 * std::log(2.0));
}

RefinedPoses refine_poses(const CaptureSet& set, const FramePoses& start, const SeenPoints& points,
                          const PoseAnchor& anchor, int threads) {
  RefinedPoses refined;
  refined.poses = observed_only(start, points);
  refined.points = points;
  refined.errors_px = errors_of(refined.poses, refined.points);
  if (refined.errors_px.empty()) throw Error("no scene point is seen by any panorama");
  const FramePoses anchors = refined.poses;
  const std::vector<RailStep> steps = rail_steps(set, refined.poses);
  // Without the slider's distances in the first pass: the start may repeat them exactly, and the
  // spread estimated from it would be too small.
  std::optional<double> spread;
  Progress progress("adjusting poses", kPasses * StepCounter::kStepsOfPass, "steps");
  for (int pass = 0; pass < kPasses; ++pass) {
    const double before_px = std::max(noise_of(refined.errors_px), kLeastNoise_px);
    Adjustment adjustment(&refined.poses, &refined.points);
    adjustment.add_observations(before_px);
    adjustment.add_anchors(anchors, anchor);
    if (spread) adjustment.add_rail(steps, *spread);
    adjustment.solve(threads, &progress);
    if (!spread) spread = rail_spread(steps, refined.poses);
    refined.errors_px = errors_of(refined.poses, refined.points);
    refined.noise_px = std::max(noise_of(refined.errors_px), kLeastNoise_px);
    // Stops when the noise has converged.
    if (pass > 0 && refined.noise_px > 0.95 * before_px) break;
  }
  refined.inlier_px = kInlierWidth * refined.noise_px;
  set_figures(&refined);
  return refined;
}

}  // namespace raywalk::calibrate
