// The fit of the step `lens` to the frames of a capture.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/image_circle.h"
#include "calibrate/lens/lens_bundle.h"
#include "calibrate/lens/lens_features.h"
#include "calibrate/lens/lens_tracks.h"
#include "calibrate/lens/motion_check.h"
#include "calibrate/lens/station_choice.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

constexpr std::size_t kLeastTracks = 100;
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

// A lens of the start with the centre and field of view of its image circle, if that was seen.
FisheyeLens moved_to(FisheyeLens lens, const std::optional<ImageCircle>& circle) {
  if (!circle) return lens;
  lens.centre = circle->centre;
  return with_rim_at(lens, circle->radius_px);
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
        stations_(choose_stations(set, static_cast<std::size_t>(options.pairs))),
        pairs_(pairs_to_match(set, stations_)) {}

  LensFit fit();

 private:
  const CaptureFrame& frame(std::size_t station) const { return set_.frames[stations_[station]]; }
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
  std::vector<std::size_t> stations_;  // indices into the frames of the set
  std::vector<StationPair> pairs_;
  std::optional<ImageCircle> front_rim_;
  std::optional<ImageCircle> back_rim_;
  DualFisheyeCamera seen_;  // the start, with what the image circles show
  std::vector<LensFeatures> features_;
  BundleInput bundle_;
  int dropped_still_ = 0;
};

void CaptureFit::find_rims() {
  // Few pictures suffice to have something bright at every point of the rim.
  constexpr std::size_t kPictures = 8;
  cv::Mat front, back;
  const std::size_t step = std::max<std::size_t>(1, stations_.size() / kPictures);
  for (std::size_t i = 0; i < stations_.size(); i += step) {
    const LensPictures pictures = read_pictures(frame(i));
    const cv::Mat in_front = level_of(pictures.front), in_back = level_of(pictures.back);
    front = front.empty() ? in_front : cv::Mat(cv::max(front, in_front));
    back = back.empty() ? in_back : cv::Mat(cv::max(back, in_back));
  }
  front_rim_ = find_image_circle(front, start_, false);
  back_rim_ = find_image_circle(back, start_, true);
  seen_ = start_;
  seen_.layout.front = moved_to(start_.layout.front, front_rim_);
  seen_.layout.back = moved_to(start_.layout.back, back_rim_);
}

void CaptureFit::find_features() {
  features_.resize(stations_.size());
  Progress progress("looking for features", count(), "stations");
  parallel_for(0, count(), 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const CaptureFrame& station = frame(i);
      FeatureOptions options;
      options.ignore_below_rad = radians_from_degrees(options_.ignore_below_deg);
      if (station.nominal_attitude) {
        options.down = world_from_camera(*station.nominal_attitude).transpose() * options.down;
      }
      features_[i] = find_lens_features(read_pictures(station), seen_, options);
      progress.advance();
    }
  });
}

void CaptureFit::prepare_bundle() {
  bundle_.start = seen_.layout;
  std::set<int> lines;
  const FramePoses poses = nominal_poses(set_);
  for (const std::size_t index : stations_) {
    lines.insert(set_.frames[index].line);
    const FramePose& pose = *poses[index];
    bundle_.stations.push_back({lines.size() - 1, pose.position_m, pose.world_from_camera});
  }
  bundle_.lines = lines.size();
}

std::vector<MatchingView> CaptureFit::views(const BundleState& state) const {
  const Viewing viewing(bundle_, state);
  std::vector<MatchingView> views;
  for (std::size_t s = 0; s < features_.size(); ++s) {
    MatchingView view{.features = &features_[s], .position_m = viewing.poses()[s].position_m};
    for (const LensFeature& feature : features_[s].features) {
      const auto ray = viewing.ray_of({s, feature.back, feature.seen});
      view.directions.push_back(ray ? ray->direction : Eigen::Vector3d::Zero());
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
  // In any direction: only near points move by more than this between neighbours. A nearest
  // distance of 1e9 m assumes no direction of motion.
  constexpr MatchingGate kAnyMotion{radians_from_degrees(35.0), 1e9};
  const std::vector<MatchingView> seen_now = views(start_of(bundle_));
  std::vector<std::vector<BearingPair>> seen(bundle_.lines);
  std::vector<Eigen::Vector3d> planned(bundle_.lines);
  for (const auto& [first, second] : pairs_) {
    const std::size_t line = bundle_.stations[first].line;
    if (second != first + 1 || bundle_.stations[second].line != line) continue;
    planned[line] = (frame(second).nominal_m - frame(first).nominal_m).normalized();
    const MatchingView &before = seen_now[first], &after = seen_now[second];
    for (const bool back : {false, true}) {
      for (const FeatureMatch& match : match_features({before, back}, {after, back}, kAnyMotion)) {
        seen[line].push_back({before.directions[match.first], after.directions[match.second]});
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
  for (std::size_t i = 0; i < stations_.size(); ++i) pairs.push_back({i, i});
  std::vector<ViewMatches> matches(pairs.size());
  Progress progress("following features", std::ssize(pairs), "pairs");
  parallel_for(0, static_cast<int>(pairs.size()), 1, [&](int begin, int end) {
    for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p) {
      const StationPair& pair = pairs[p];
      const MatchingView &first = seen_now[pair.first], &second = seen_now[pair.second];
      const MatchingGate allowed = gate(pair, tolerance_rad);
      ViewMatches& found = matches[p];
      found = {pair.first, pair.second, {}};
      if (pair.first == pair.second) {
        found.matches = match_features({first, false}, {second, true}, allowed);
      } else {
        found.matches = match_features({first, false}, {second, false}, allowed);
        const auto in_back = match_features({first, true}, {second, true}, allowed);
        found.matches.insert(found.matches.end(), in_back.begin(), in_back.end());
      }
      progress.advance();
    }
  });
  bundle_.tracks = join_tracks(features_, matches);
  const Eigen::Vector3d down =
      bundle_.stations.front().nominal_world_from_camera.transpose() * Eigen::Vector3d(0, -1, 0);
  dropped_still_ = remove_still_tracks(layout_of(state.camera, bundle_.start), bundle_.stations,
                                       down, kStillCone_rad, &bundle_.tracks);
  thin_tracks(most_tracks, &bundle_.tracks);
}

LensFit CaptureFit::result(const BundleResult& bundle) const {
  LensFit fit{.start = start_,
              .camera = start_,
              .pictures = count(),
              .points = bundle.tracks_kept,
              .observations = static_cast<int>(bundle.residuals.size()),
              .overlap_points = bundle.overlap_tracks,
              .dropped_still = dropped_still_,
              .dropped_observations = bundle.observations_dropped,
              .residuals = bundle.residuals};
  DualFisheyeLayout& layout = fit.camera.layout;
  layout = layout_of(bundle.state.camera, bundle_.start);
  layout.front = ending_at_rim(layout.front, seen_.layout.front, front_rim_);
  layout.back = ending_at_rim(layout.back, seen_.layout.back, back_rim_);
  double squares = 0.0;
  for (const LensResidual& residual : fit.residuals) {
    squares += residual.right_px * residual.right_px + residual.down_px * residual.down_px;
  }
  fit.residual_px = std::sqrt(squares / std::max(1, fit.observations));
  if (bundle.covariance) {
    const CameraCovariance covariance = kErrorCorrelation * kErrorCorrelation * *bundle.covariance;
    fit.sigma = uncertainty_of(bundle.state.camera, covariance, layout);
  } else {
    fit.warnings.emplace_back("the uncertainty of the lenses is unknown: the fit is singular");
  }
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
