#include "calibrate/lens/lens_bundle.h"

#include <ceres/covariance.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>
#include <ceres/rotation.h>
#include <ceres/solver.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "calibrate/base/stop_on_interrupt.h"
#include "calibrate/lens/bundle_problem.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/parallel.h"

namespace raywalk::calibrate {
namespace {

// Two observations only determine their point; three also constrain the lenses.
constexpr std::size_t kLeastObservations = 3;
// An observation further from the fit than this many standard deviations is an outlier.
constexpr double kOutlierSigmas = 5.0;

bool enough(const BundleTrack& track) {
  const auto elsewhere = [&](const BundleObservation& seen) {
    return seen.station != track.front().station;
  };
  return track.size() >= kLeastObservations && std::ranges::any_of(track, elsewhere);
}

class Adjustment {
 public:
  Adjustment(const BundleInput& input, const BundleState& from)
      : input_(input), middles_(line_middles(input)), state_(from) {}

  // Selects observations within kOutlierSigmas sigma_px of the state's prediction.
  void choose(double sigma_px, std::size_t least_tracks) {
    const Viewing viewing(input_, state_);
    active_.clear();
    for (const BundleTrack& track : input_.tracks) {
      if (auto active = agreeing(viewing, track, kOutlierSigmas * sigma_px)) {
        active_.push_back(std::move(*active));
      }
    }
    if (active_.size() >= least_tracks) return;
    throw Error(fmt::format(
        "only {} features of {} tracked agree with each other and with the rail's positions; {} "
        "are needed: use more stations (--pairs), a scene with more texture, or better starting "
        "values of the lenses",
        active_.size(), input_.tracks.size(), least_tracks));
  }

  void solve(double sigma_px, int most_iterations) {
    ceres::Problem problem;
    build_problem(input_, sigma_px, &state_, &active_, &problem);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = most_iterations;
    options.num_threads = thread_count();
    options.logging_type = ceres::SILENT;
    // Points are eliminated first: each is seen from few stations, so the Schur complement is
    // sparse.
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double*> blocks;
    problem.GetParameterBlocks(&blocks);
    for (double* block : blocks) ordering->AddElementToGroup(block, 1);
    for (ActiveTrack& active : active_) ordering->AddElementToGroup(active.point.value.data(), 0);
    options.linear_solver_ordering = std::move(ordering);
    StopOnInterrupt stop;
    options.callbacks.push_back(&stop);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    throw_if_interrupted();
    if (summary.IsSolutionUsable()) return;
    throw Error(
        "the fit of the lenses does not converge; use better starting values of the lenses");
  }

  double robust_sigma_px() const {
    std::vector<double> sizes;
    for (const LensResidual& residual : residuals()) {
      sizes.push_back(std::fabs(residual.right_px));
      sizes.push_back(std::fabs(residual.down_px));
    }
    return robust_sigma(std::move(sizes));
  }

  // Of front, back and back_pose, which are parameters of the problem; nullopt if it does not
  // determine them.
  std::optional<CameraCovariance> covariance(double sigma_px) {
    ceres::Problem problem;
    build_problem(input_, sigma_px, &state_, &active_, &problem);
    ceres::Covariance::Options options;
    options.num_threads = thread_count();
    ceres::Covariance covariance(options);
    const CameraParameters& camera = state_.camera;
    const std::vector<const double*> blocks{camera.front.data(), camera.back.data(),
                                            camera.back_pose.data()};
    if (!covariance.Compute(blocks, &problem)) return std::nullopt;
    Eigen::Matrix<double, kCameraParameters, kCameraParameters, Eigen::RowMajor> matrix;
    if (!covariance.GetCovarianceMatrix(blocks, matrix.data())) return std::nullopt;
    return matrix;
  }

  std::vector<LensResidual> residuals() const {
    std::vector<LensResidual> all;
    for (const ActiveTrack& active : active_) {
      for (const BundleObservation& seen : active.seen) {
        const Eigen::Vector2d px = residual(seen, active.point);
        all.push_back({seen.back, seen.seen, px.x(), px.y()});
      }
    }
    return all;
  }

  const BundleState& state() const { return state_; }
  const std::vector<ActiveTrack>& active() const { return active_; }

 private:
  Eigen::Vector2d residual(const BundleObservation& seen, const TrackPoint& point) const {
    return residual_of(input_, state_, middles_[input_.stations[seen.station].line], point, seen);
  }

  // Removes the worst observation until the rest agree; nullopt if too few do.
  std::optional<ActiveTrack> agreeing(const Viewing& viewing, const BundleTrack& track,
                                      double most_px) const {
    ActiveTrack active;
    std::vector<ViewRay> rays;
    for (const BundleObservation& seen : track) {
      const auto ray = viewing.ray_of(seen);
      if (!ray) continue;
      rays.push_back(*ray);
      active.seen.push_back(seen);
    }
    while (enough(active.seen)) {
      const auto point = triangulate(rays);
      if (!point) return std::nullopt;
      active.point = *point;
      std::vector<double> off_px;
      for (const BundleObservation& seen : active.seen) {
        off_px.push_back(residual(seen, *point).norm());
      }
      const auto worst = std::ranges::max_element(off_px);
      if (*worst <= most_px) return active;
      active.seen.erase(active.seen.begin() + (worst - off_px.begin()));
      rays.erase(rays.begin() + (worst - off_px.begin()));
    }
    return std::nullopt;
  }

  const BundleInput& input_;
  std::vector<Eigen::Vector3d> middles_;
  BundleState state_;
  std::vector<ActiveTrack> active_;
};

}  // namespace

bool spans_both_lenses(const BundleTrack& track) {
  return std::ranges::any_of(
      track, [&](const BundleObservation& seen) { return seen.back != track.front().back; });
}

BundleState start_of(const BundleInput& input) {
  return {parameters_of(input.start), std::vector<PoseParameters>(input.lines),
          std::vector<PoseParameters>(input.stations.size())};
}

std::vector<BundlePose> poses_of(const BundleInput& input, const BundleState& state) {
  const std::vector<Eigen::Vector3d> middles = line_middles(input);
  std::vector<BundlePose> poses;
  for (std::size_t s = 0; s < input.stations.size(); ++s) {
    const BundleStation& station = input.stations[s];
    const Eigen::Vector3d& middle_m = middles[station.line];
    const PoseParameters& of_line = state.lines[station.line];
    const PoseParameters& of_station = state.stations[s];
    Eigen::Matrix3d line_turn, station_turn;
    ceres::AngleAxisToRotationMatrix(of_line.data(), line_turn.data());
    ceres::AngleAxisToRotationMatrix(of_station.data(), station_turn.data());
    const Eigen::Vector3d shift_m(of_line[3] + of_station[3], of_line[4] + of_station[4],
                                  of_line[5] + of_station[5]);
    poses.push_back({middle_m + line_turn * (station.nominal_m - middle_m) + shift_m,
                     station.nominal_world_from_camera * station_turn.transpose()});
  }
  return poses;
}

Viewing::Viewing(const BundleInput& input, const BundleState& state)
    : layout_(layout_of(state.camera, input.start)),
      camera_from_back_(world_from_camera(layout_.back_attitude)),
      poses_(poses_of(input, state)) {}

std::optional<ViewRay> Viewing::ray_of(const BundleObservation& seen) const {
  const auto in_lens = unproject(seen.back ? layout_.back : layout_.front, seen.seen);
  if (!in_lens) return std::nullopt;
  const BundlePose& pose = poses_[seen.station];
  const Eigen::Vector3d in_camera = seen.back ? camera_from_back_ * *in_lens : *in_lens;
  const Eigen::Vector3d& lens_m = seen.back ? layout_.back_position_m : layout_.front_position_m;
  return ViewRay{pose.position_m + pose.world_from_camera * lens_m,
                 pose.world_from_camera * in_camera};
}

BundleResult adjust_bundle(const BundleInput& input, const BundleState& from,
                           const BundleOptions& options) {
  constexpr int kRounds = 5;
  constexpr int kIterationsPerRound = 8;
  constexpr int kLastIterations = 50;
  // Lower bound of the features' noise.
  constexpr double kLeastSigma_px = 0.02;
  Adjustment adjustment(input, from);
  double sigma_px = options.tolerance_px;
  for (int round = 0; round < kRounds; ++round) {
    adjustment.choose(sigma_px, options.least_tracks);
    adjustment.solve(sigma_px, round + 1 < kRounds ? kIterationsPerRound : kLastIterations);
    sigma_px = std::clamp(adjustment.robust_sigma_px(), kLeastSigma_px, sigma_px);
  }
  BundleResult result;
  if (options.want_covariance) result.covariance = adjustment.covariance(sigma_px);
  result.state = adjustment.state();
  result.residuals = adjustment.residuals();
  result.sigma_px = sigma_px;
  for (const ActiveTrack& active : adjustment.active()) {
    ++result.tracks_kept;
    if (spans_both_lenses(active.seen)) ++result.overlap_tracks;
  }
  std::size_t all = 0;
  for (const BundleTrack& track : input.tracks) all += track.size();
  result.observations_dropped = static_cast<int>(all - result.residuals.size());
  return result;
}

}  // namespace raywalk::calibrate
