// Matches between pictures joined into tracks: a feature of the scene, wherever it was seen.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibrate/lens/lens_bundle.h"
#include "calibrate/lens/lens_features.h"
#include "calibrate/lens/lens_matching.h"

namespace raywalk::calibrate {

struct ViewMatches {
  int first = 0;  // stations
  int second = 0;
  std::vector<FeatureMatch> matches{};
};

// Tracks of at least three observations from at least two stations. A track that holds two features
// of one lens at one station is a chain with a wrong link and is left out.
std::vector<BundleTrack> join_tracks(std::span<const LensFeatures> stations,
                                     std::span<const ViewMatches> matches);

// Takes out tracks that stand still in the picture while the camera moves, in directions within
// `cone_rad` of `down` (camera frame): down there is a floor, which moves, so they are the dolly
// and what is mounted on it. Infinitely far points stand still as well, but elsewhere. Returns
// their number.
int remove_still_tracks(const DualFisheyeLayout& layout, std::span<const Eigen::Vector3d> nominal_m,
                        const Eigen::Vector3d& down, double cone_rad,
                        std::vector<BundleTrack>* tracks);

// Leaves at most `most` tracks: those seen by both lenses, which are rare, and of the others an
// even share, so that they stay spread as they are.
void thin_tracks(std::size_t most, std::vector<BundleTrack>* tracks);

}  // namespace raywalk::calibrate
