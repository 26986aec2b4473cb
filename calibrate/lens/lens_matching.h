// Matches features of two fisheye pictures.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibrate/lens/lens_features.h"
#include "calibrate/lens/track_point.h"

namespace raywalk::calibrate {

// The features of a station with their rays at the current estimate.
struct MatchingView {
  const LensFeatures* features = nullptr;
  std::vector<ViewRay> rays{};  // of every feature; zero direction: no ray
};

struct FeatureMatch {
  int first = 0;  // indices into the features of both views
  int second = 0;
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
  const MatchingView* view = nullptr;
  bool back = false;
};
std::vector<FeatureMatch> match_features(const LensOfView& first, const LensOfView& second,
                                         const MatchingGate& gate);

}  // namespace raywalk::calibrate
