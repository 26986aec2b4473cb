// Matches features of fisheye pictures, and joins the matches into tracks: all observations of one
// scene feature.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "calibrate/lens/lens_bundle.h"
#include "calibrate/lens/lens_features.h"

namespace raywalk::calibrate {

// The features of a station as seen by the current estimate. The lenses of a station are so close
// together that its position is taken for that of both.
struct MatchingView {
  const LensFeatures* features = nullptr;
  Eigen::Vector3d position_m{0, 0, 0};
  std::vector<Eigen::Vector3d> directions{};  // of every feature, world axes; zero: none
};

struct FeatureMatch {
  std::size_t first = 0;  // indices into the features of both views
  std::size_t second = 0;
};

// The epipolar constraint on matches.
struct MatchingGate {
  // Largest angle of a feature from the segment of the epipolar line between the point at infinity
  // and the one at `nearest_m`.
  double tolerance_rad = 0.1;
  double nearest_m = 0.3;
};

// Matches features of one lens with those of one lens in another (or the same) picture: mutual
// nearest neighbours by descriptor, among those that the gate allows, that pass Lowe's ratio test.
struct LensOfView {
  const MatchingView& view;
  bool back = false;
};
std::vector<FeatureMatch> match_features(const LensOfView& first, const LensOfView& second,
                                         const MatchingGate& gate);

struct ViewMatches {
  std::size_t first = 0;  // stations
  std::size_t second = 0;
  std::vector<FeatureMatch> matches{};
};

// Tracks of at least three observations from at least two stations. A track with two features of
// one lens at one station contains a wrong match and is dropped.
std::vector<BundleTrack> join_tracks(std::span<const LensFeatures> stations,
                                     std::span<const ViewMatches> matches);

// Removes tracks that stand still in the picture while the camera moves, in directions within
// `cone_rad` of `down` (camera frame), and returns their number. The floor there would move, so
// they show the dolly and what is mounted on it. Points at infinity stand still too, but not in
// these directions. `layout`: the current estimate.
int remove_still_tracks(const DualFisheyeLayout& layout, std::span<const BundleStation> stations,
                        const Eigen::Vector3d& down, double cone_rad,
                        std::vector<BundleTrack>* tracks);

// Keeps at most `most` tracks: those seen by both lenses, which are rare, and an evenly spaced
// subset of the others.
void thin_tracks(std::size_t most, std::vector<BundleTrack>* tracks);

}  // namespace raywalk::calibrate
