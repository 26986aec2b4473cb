#include "calibrate/lens/lens_bundle.h"

#include <ceres/problem.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "calibrate/lens/bundle_problem.h"
#include "calibrate/lens/fit_details.h"
#include "core/base/error.h"
#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

// Two observations only determine their point; three also constrain the lenses.
constexpr std::size_t kLeastObservations = 3;

bool enough(const BundleTrack& track, const std::vector<int>& observations) {
  if (observations.size() < kLeastObservations) return false;
  std::set<int> stations;
  for (const int i : observations) stations.insert(track[static_cast<std::size_t>(i)].station);
  return stations.size() > 1;
}

// Converts observations to rays by the current state.
class Viewing {
 public:
  Viewing(const BundleInput& input, const BundleState& state)
      : layout_(layout_of(state.camera, input.start)),
        camera_from_back_(world_from_camera(layout_.back_attitude)),
        poses_(poses_of(input, state)) {}

  std::optional<ViewRay> ray_of(const BundleObservation& seen) const {
    const auto in_lens = unproject(seen.back ? layout_.back : layout_.front, seen.seen);
    if (!in_lens) return std::nullopt;
    const BundlePose& pose = poses_[static_cast<std::size_t>(seen.station)];
    const Eigen::Vector3d in_camera = seen.back ? camera_from_back_ * *in_lens : *in_lens;
    const Eigen::Vector3d& lens_m = seen.back ? layout_.back_position_m : layout_.front_position_m;
    return ViewRay{pose.position_m + pose.world_from_camera * lens_m,
                   pose.world_from_camera * in_camera};
  }

 private:
  DualFisheyeLayout layout_;
  Eigen::Matrix3d camera_from_back_;
  std::vector<BundlePose> poses_;
};

std::optional<TrackPoint> point_of(const Viewing& viewing, const BundleTrack& track,
                                   std::vector<int>* observations) {
  std::vector<ViewRay> rays;
  std::vector<int> seen;
  for (const int i : *observations) {
    if (const auto ray = viewing.ray_of(track[static_cast<std::size_t>(i)])) {
      rays.push_back(*ray);
      seen.push_back(i);
    }
  }
  *observations = std::move(seen);
  if (!enough(track, *observations)) return std::nullopt;
  return triangulate(rays);
}

class Adjustment {
 public:
  Adjustment(const BundleInput& input, const BundleState& from)
      : input_(input), middles_(line_middles(input)), state_(from) {}

  // Selects observations within kOutlierSigmas sigma_px of the state's prediction.
  void choose(double sigma_px) {
    const Viewing viewing(input_, state_);
    active_.clear();
    for (std::size_t t = 0; t < input_.tracks.size(); ++t) {
      if (auto active = agreeing(viewing, static_cast<int>(t), kOutlierSigmas * sigma_px)) {
        active_.push_back(std::move(*active));
      }
    }
  }

  void require_tracks(int least) const {
    if (static_cast<int>(active_.size()) >= least) return;
    throw Error(fmt::format(
        "only {} features of {} tracked agree with each other and with the rail's positions; {} "
        "are needed: use more stations (--pairs), a scene with more texture, or better starting "
        "values of the lenses",
        active_.size(), input_.tracks.size(), least));
  }

  void solve(double sigma_px, int most_iterations) {
    ceres::Problem problem;
    build_problem(input_, sigma_px, &state_, &active_, &problem);
    std::vector<double*> points;
    for (ActiveTrack& active : active_) points.push_back(active.point.value.data());
    // Points are eliminated first: each is seen from few stations, so the Schur complement is
    // sparse.
    solve_fit(&problem, points, most_iterations);
  }

  double robust_sigma_px() const {
    std::vector<double> sizes;
    for (const BundleResidual& residual : residuals()) {
      sizes.push_back(std::fabs(residual.right_px));
      sizes.push_back(std::fabs(residual.down_px));
    }
    return robust_sigma(std::move(sizes));
  }

  std::vector<BundleResidual> residuals() const {
    std::vector<BundleResidual> all;
    for (const ActiveTrack& active : active_) {
      for (const int i : active.observations) {
        const Eigen::Vector2d px = residual(active.track, i, active.point);
        all.push_back({active.track, i, px.x(), px.y()});
      }
    }
    return all;
  }

  std::optional<CameraCovariance> covariance(double sigma_px) {
    ceres::Problem problem;
    build_problem(input_, sigma_px, &state_, &active_, &problem);
    return camera_covariance(&problem, state_.camera);
  }

  const BundleState& state() const { return state_; }
  int tracks() const { return static_cast<int>(active_.size()); }

 private:
  Eigen::Vector2d residual(int track, int observation, const TrackPoint& point) const {
    const BundleObservation& seen =
        input_.tracks[static_cast<std::size_t>(track)][static_cast<std::size_t>(observation)];
    const int line = input_.stations[static_cast<std::size_t>(seen.station)].line;
    return residual_of(input_, state_, middles_[static_cast<std::size_t>(line)], point, seen);
  }

  // Removes the worst observation until the rest agree; nullopt if too few do.
  std::optional<ActiveTrack> agreeing(const Viewing& viewing, int track, double most_px) const {
    const BundleTrack& seen = input_.tracks[static_cast<std::size_t>(track)];
    ActiveTrack active{track, {}, {}};
    for (std::size_t i = 0; i < seen.size(); ++i)
      active.observations.push_back(static_cast<int>(i));
    while (true) {
      const auto point = point_of(viewing, seen, &active.observations);
      if (!point) return std::nullopt;
      active.point = *point;
      double worst_px = 0.0;
      std::size_t worst = 0;
      for (std::size_t i = 0; i < active.observations.size(); ++i) {
        const double px = residual(track, active.observations[i], *point).norm();
        if (px > worst_px) {
          worst_px = px;
          worst = i;
        }
      }
      if (worst_px <= most_px) return active;
      active.observations.erase(active.observations.begin() + static_cast<std::ptrdiff_t>(worst));
    }
  }

  const BundleInput& input_;
  std::vector<Eigen::Vector3d> middles_;
  BundleState state_;
  std::vector<ActiveTrack> active_;
};

}  // namespace

BundleState start_of(const BundleInput& input) {
  return {parameters_of(input.start),
          std::vector<PoseParameters>(static_cast<std::size_t>(input.lines)),
          std::vector<PoseParameters>(input.stations.size())};
}

std::vector<BundlePose> poses_of(const BundleInput& input, const BundleState& state) {
  const std::vector<Eigen::Vector3d> middles = line_middles(input);
  std::vector<BundlePose> poses;
  for (std::size_t s = 0; s < input.stations.size(); ++s) {
    const BundleStation& station = input.stations[s];
    const auto line = static_cast<std::size_t>(station.line);
    const PoseParameters& of_line = state.lines[line];
    const PoseParameters& of_station = state.stations[s];
    Eigen::Matrix3d line_turn, station_turn;
    ceres::AngleAxisToRotationMatrix(of_line.data(), line_turn.data());
    ceres::AngleAxisToRotationMatrix(of_station.data(), station_turn.data());
    const Eigen::Vector3d shift_m(of_line[3] + of_station[3], of_line[4] + of_station[4],
                                  of_line[5] + of_station[5]);
    poses.push_back({middles[line] + line_turn * (station.nominal_m - middles[line]) + shift_m,
                     station.nominal_world_from_camera * station_turn.transpose()});
  }
  return poses;
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
    adjustment.choose(sigma_px);
    adjustment.require_tracks(options.least_tracks);
    adjustment.solve(sigma_px, round + 1 < kRounds ? kIterationsPerRound : kLastIterations);
    sigma_px = std::clamp(adjustment.robust_sigma_px(), kLeastSigma_px, sigma_px);
  }
  BundleResult result;
  if (options.want_covariance) result.covariance = adjustment.covariance(sigma_px);
  result.state = adjustment.state();
  result.residuals = adjustment.residuals();
  result.tracks_kept = adjustment.tracks();
  result.sigma_px = sigma_px;
  std::size_t all = 0;
  for (const BundleTrack& track : input.tracks) all += track.size();
  result.observations_dropped = static_cast<int>(all - result.residuals.size());
  return result;
}

}  // namespace raywalk::calibrate
