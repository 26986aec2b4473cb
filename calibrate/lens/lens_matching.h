// Which features of two pictures show the same thing.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibrate/lens/lens_features.h"
#include "calibrate/lens/track_point.h"

namespace raywalk::calibrate {

// The features of a station with what is known of their directions at the time of matching.
struct MatchingView {
  const LensFeatures* features = nullptr;
  std::vector<ViewRay> rays{};  // of every feature; a direction of 0 where it has none
};

struct FeatureMatch {
  int first = 0;  // indices into the features of both views
  int second = 0;
};

// What the geometry allows for the second picture, given the first.
struct MatchingGate {
  // A feature may be off the plane through both cameras (the epipolar plane) by this angle, and so
  // far beyond its ends: the infinitely far point and one at `nearest_m`.
  double tolerance_rad = 0.1;
  double nearest_m = 0.3;
};

// Features of one lens matched with those of one lens in another (or the same) picture: nearest by
// descriptor among those that the gate allows, clearly nearer than the second (Lowe's ratio), and
// the same from both sides.
struct LensOfView {
  const MatchingView* view = nullptr;
  bool back = false;
};
std::vector<FeatureMatch> match_features(const LensOfView& first, const LensOfView& second,
                                         const MatchingGate& gate);

}  // namespace raywalk::calibrate
