#include "calibrate/lens/capture_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>

#include "calibrate/base/frame_masks.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/lens/feature_tracks.h"
#include "calibrate/lens/fit_details.h"
#include "calibrate/lens/image_circle.h"
#include "calibrate/lens/lens_bundle.h"
#include "calibrate/lens/lens_features.h"
#include "calibrate/lens/lens_matching.h"
#include "calibrate/lens/motion_check.h"
#include "calibrate/lens/station_choice.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

constexpr int kLeastTracks = 100;
// More tracks take longer and gain little: errors fall with the square root of the number. The
// first fit only has to guide the second matching.
constexpr std::size_t kFirstTracks = 1200;
constexpr std::size_t kLastTracks = 3500;
// Tolerance of the first matching for errors of the starting lenses and attitudes together.
constexpr double kStartTolerance_rad = radians_from_degrees(6.0);
// Tolerance of the first fit, as a share of the focal length.
constexpr double kStartResidual = 0.025;
// Tolerance of the second matching, with fitted lenses and attitudes.
constexpr double kFittedTolerance_rad = radians_from_degrees(0.7);
// Errors of a feature are correlated between neighbouring stations, as its appearance changes
// little, but the covariance assumes independence. In simulated rooms with ground truth the errors
// of lenses were 1.2 to 2.3 times the sigmas for independent errors.
constexpr double kErrorCorrelation = 2.0;
// Whatever stands still within this angle of the nadir is the dolly.
constexpr double kStillCone_rad = radians_from_degrees(40.0);

LensPictures read_pictures(const CaptureFrame& frame) {
  LensPictures pictures;
  pictures.front = read_picture(frame.file);
  pictures.back = frame.back ? read_picture(*frame.back) : pictures.front;
  pictures.mask = own_mask(frame, {pictures.front.cols, pictures.front.rows});
  return pictures;
}

cv::Mat level_of(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// The start, with centre and field of view from the observed image circles.
struct Rims {
  DualFisheyeCamera camera{};
  std::optional<ImageCircle> front{};
  std::optional<ImageCircle> back{};
};

FisheyeLens moved_to(const FisheyeLens& lens, const std::optional<ImageCircle>& circle) {
  if (!circle) return lens;
  FisheyeLens moved = with_rim_at(lens, circle->radius_px);
  moved.centre = circle->centre;
  return moved;
}

// A fitted lens with the observed field of view. Pixels on the rim itself are partly dark, so it
// ends a pixel before. Without an observed rim it ends at the radius of the start.
FisheyeLens ending_at_rim(const FisheyeLens& fitted, const FisheyeLens& start,
                          const std::optional<ImageCircle>& circle) {
  constexpr double kRimWidth_px = 1.0;
  return with_rim_at(fitted, circle ? circle->radius_px - kRimWidth_px : rim_radius_px(start));
}

class CaptureFit {
 public:
  CaptureFit(const CaptureSet& set, const DualFisheyeCamera& start, const LensOptions& options)
      : set_(set),
        start_(start),
        options_(options),
        stations_(choose_stations(set, options.pairs)) {
    pairs_ = pairs_to_match(set, stations_);
  }

  LensFit fit();

 private:
  const CaptureFrame& frame(int station) const {
    return set_.frames[static_cast<std::size_t>(stations_[static_cast<std::size_t>(station)])];
  }
  int count() const { return static_cast<int>(stations_.size()); }

  void find_rims();
  void find_features();
  void prepare_bundle();
  void check_motion() const;
  std::vector<MatchingView> views(const BundleState& state) const;
  MatchingGate gate(const StationPair& pair, double tolerance_rad) const;
  void follow(const BundleState& state, double tolerance_rad, std::size_t most_tracks);
  LensFit result(const BundleResult& bundle) const;

  const CaptureSet& set_;
  const DualFisheyeCamera& start_;
  const LensOptions& options_;
  std::vector<int> stations_;
  std::vector<StationPair> pairs_;
  Rims rims_;
  std::vector<LensFeatures> features_;
  BundleInput bundle_;
  int dropped_still_ = 0;
};

void CaptureFit::find_rims() {
  // Few pictures suffice to have something bright at every point of the rim.
  constexpr int kPictures = 8;
  cv::Mat front, back;
  const int step = std::max(1, count() / kPictures);
  for (int i = 0; i < count(); i += step) {
    const LensPictures pictures = read_pictures(frame(i));
    const cv::Mat in_front = level_of(pictures.front), in_back = level_of(pictures.back);
    front = front.empty() ? in_front : cv::Mat(cv::max(front, in_front));
    back = back.empty() ? in_back : cv::Mat(cv::max(back, in_back));
  }
  rims_.front = find_image_circle(front, start_, false);
  rims_.back = find_image_circle(back, start_, true);
  rims_.camera = start_;
  rims_.camera.layout.front = moved_to(start_.layout.front, rims_.front);
  rims_.camera.layout.back = moved_to(start_.layout.back, rims_.back);
}

void CaptureFit::find_features() {
  features_.resize(stations_.size());
  Progress progress("looking for features", count(), "stations");
  parallel_for(0, count(), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const CaptureFrame& station = frame(i);
      FeatureOptions options;
      options.ignore_below_rad = radians_from_degrees(options_.ignore_below_deg);
      if (station.nominal_attitude) {
        options.down = world_from_camera(*station.nominal_attitude).transpose() * options.down;
      }
      features_[static_cast<std::size_t>(i)] =
          find_lens_features(read_pictures(station), rims_.camera, options);
      progress.advance();
    }
  });
}

void CaptureFit::prepare_bundle() {
  bundle_.start = rims_.camera.layout;
  std::set<int> lines;
  const FramePoses poses = nominal_poses(set_);
  for (const int index : stations_) {
    const int line = set_.frames[static_cast<std::size_t>(index)].line;
    lines.insert(line);
    const auto number = static_cast<int>(std::distance(lines.begin(), lines.find(line)));
    const FramePose& pose = *poses[static_cast<std::size_t>(index)];
    bundle_.stations.push_back({number, pose.position_m, pose.world_from_camera});
  }
  bundle_.lines = static_cast<int>(lines.size());
}

std::vector<MatchingView> CaptureFit::views(const BundleState& state) const {
  const DualFisheyeLayout layout = layout_of(state.camera, bundle_.start);
  const Eigen::Matrix3d camera_from_back = world_from_camera(layout.back_attitude);
  const std::vector<BundlePose> poses = poses_of(bundle_, state);
  std::vector<MatchingView> views;
  for (std::size_t s = 0; s < features_.size(); ++s) {
    MatchingView view{&features_[s], {}};
    for (const LensFeature& feature : features_[s].features) {
      const auto in_lens = unproject(feature.back ? layout.back : layout.front, feature.seen);
      Eigen::Vector3d in_camera = in_lens ? *in_lens : Eigen::Vector3d::Zero();
      if (feature.back) in_camera = camera_from_back * in_camera;
      view.rays.push_back({poses[s].position_m, poses[s].world_from_camera * in_camera});
    }
    views.push_back(std::move(view));
  }
  return views;
}

// A point nearer than the distance between two stations moves by more than 45 degrees, too much to
// match.
MatchingGate CaptureFit::gate(const StationPair& pair, double tolerance_rad) const {
  return {tolerance_rad, (frame(pair.first).nominal_m - frame(pair.second).nominal_m).norm()};
}

void CaptureFit::check_motion() const {
  // In any direction: only near points move by more than this between neighbours.
  constexpr double kLargestMotion_rad = radians_from_degrees(35.0);
  const std::vector<MatchingView> seen_now = views(start_of(bundle_));
  std::vector<std::vector<BearingPair>> seen(static_cast<std::size_t>(bundle_.lines));
  std::vector<Eigen::Vector3d> planned(seen.size());
  for (const StationPair& pair : pairs_) {
    if (pair.second != pair.first + 1 || frame(pair.first).line != frame(pair.second).line)
      continue;
    const MatchingView& first = seen_now[static_cast<std::size_t>(pair.first)];
    const MatchingView& second = seen_now[static_cast<std::size_t>(pair.second)];
    const auto line =
        static_cast<std::size_t>(bundle_.stations[static_cast<std::size_t>(pair.first)].line);
    planned[line] = (frame(pair.second).nominal_m - frame(pair.first).nominal_m).normalized();
    for (const bool back : {false, true}) {
      // A nearest distance of 1e9 m assumes no direction of motion.
      for (const FeatureMatch& match :
           match_features({&first, back}, {&second, back}, {kLargestMotion_rad, 1e9})) {
        seen[line].push_back({first.rays[static_cast<std::size_t>(match.first)].direction,
                              second.rays[static_cast<std::size_t>(match.second)].direction});
      }
    }
  }
  std::vector<MotionComparison> motions;
  for (std::size_t line = 0; line < seen.size(); ++line) {
    if (const auto motion = motion_direction(seen[line]))
      motions.push_back({planned[line], *motion});
  }
  require_motion_as_planned(motions);
}

void CaptureFit::follow(const BundleState& state, double tolerance_rad, std::size_t most_tracks) {
  const std::vector<MatchingView> seen_now = views(state);
  std::vector<StationPair> pairs = pairs_;
  for (int i = 0; i < count(); ++i) pairs.push_back({i, i});
  std::vector<ViewMatches> matches(pairs.size());
  Progress progress("following features", static_cast<std::int64_t>(pairs.size()), "pairs");
  parallel_for(0, static_cast<int>(pairs.size()), 1, [&](int begin, int end) {
    for (int p = begin; p < end; ++p) {
      const StationPair& pair = pairs[static_cast<std::size_t>(p)];
      const MatchingView& first = seen_now[static_cast<std::size_t>(pair.first)];
      const MatchingView& second = seen_now[static_cast<std::size_t>(pair.second)];
      ViewMatches& found = matches[static_cast<std::size_t>(p)];
      found = {pair.first, pair.second, {}};
      const bool across = pair.first == pair.second;  // the two lenses of one station
      for (const bool back : {false, true}) {
        if (across && back) continue;
        const auto more = match_features({&first, back}, {&second, across ? !back : back},
                                         gate(pair, tolerance_rad));
        found.matches.insert(found.matches.end(), more.begin(), more.end());
      }
      progress.advance();
    }
  });
  bundle_.tracks = join_tracks(features_, matches);
  std::vector<Eigen::Vector3d> nominal_m;
  for (const BundleStation& station : bundle_.stations) nominal_m.push_back(station.nominal_m);
  const Eigen::Vector3d down =
      bundle_.stations.front().nominal_world_from_camera.transpose() * Eigen::Vector3d(0, -1, 0);
  dropped_still_ = remove_still_tracks(layout_of(state.camera, bundle_.start), nominal_m, down,
                                       kStillCone_rad, &bundle_.tracks);
  thin_tracks(most_tracks, &bundle_.tracks);
}

LensFit CaptureFit::result(const BundleResult& bundle) const {
  LensFit fit;
  fit.start = start_;
  fit.camera = start_;
  fit.camera.layout = layout_of(bundle.state.camera, bundle_.start);
  fit.camera.layout.front =
      ending_at_rim(fit.camera.layout.front, rims_.camera.layout.front, rims_.front);
  fit.camera.layout.back =
      ending_at_rim(fit.camera.layout.back, rims_.camera.layout.back, rims_.back);
  std::optional<CameraCovariance> covariance = bundle.covariance;
  if (covariance) *covariance *= kErrorCorrelation * kErrorCorrelation;
  set_uncertainty(bundle.state.camera, covariance, &fit);
  fit.pictures = count();
  fit.points = bundle.tracks_kept;
  fit.dropped_still = dropped_still_;
  fit.dropped_observations = bundle.observations_dropped;
  std::vector<std::array<bool, 2>> seen_by(bundle_.tracks.size(), {false, false});
  std::vector<FitResidual> residuals;
  for (const BundleResidual& residual : bundle.residuals) {
    const auto track = static_cast<std::size_t>(residual.track);
    const BundleObservation& seen =
        bundle_.tracks[track][static_cast<std::size_t>(residual.observation)];
    seen_by[track][seen.back ? 1 : 0] = true;
    residuals.push_back({seen.back, seen.seen, {residual.right_px, residual.down_px}});
  }
  set_residuals(residuals, &fit);
  fit.overlap_points = static_cast<int>(
      std::count_if(seen_by.begin(), seen_by.end(), [](const auto& by) { return by[0] && by[1]; }));
  return fit;
}

LensFit CaptureFit::fit() {
  find_rims();
  find_features();
  prepare_bundle();
  check_motion();
  BundleState state = start_of(bundle_);
  follow(state, kStartTolerance_rad, kFirstTracks);
  const double focal_px = bundle_.start.front.focal_px;
  state = adjust_bundle(bundle_, state, {kStartResidual * focal_px, kLeastTracks, false}).state;
  follow(state, kFittedTolerance_rad, kLastTracks);
  const BundleResult bundle =
      adjust_bundle(bundle_, state, {0.25 * kFittedTolerance_rad * focal_px, kLeastTracks, true});
  return result(bundle);
}

}  // namespace

LensFit fit_to_capture(const CaptureSet& set, const DualFisheyeCamera& start,
                       const LensOptions& options) {
  return CaptureFit(set, start, options).fit();
}

}  // namespace raywalk::calibrate
