// Joins matches between pictures into tracks: all observations of one scene feature.
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

// Tracks of at least three observations from at least two stations. A track with two features of
// one lens at one station contains a wrong match and is dropped.
std::vector<BundleTrack> join_tracks(std::span<const LensFeatures> stations,
                                     std::span<const ViewMatches> matches);

// Removes tracks that stand still in the picture while the camera moves, in directions within
// `cone_rad` of `down` (camera frame), and returns their number. The floor there would move, so
// they show the dolly and what is mounted on it. Points at infinity stand still too, but not in
// these directions.
int remove_still_tracks(const DualFisheyeLayout& layout, std::span<const Eigen::Vector3d> nominal_m,
                        const Eigen::Vector3d& down, double cone_rad,
                        std::vector<BundleTrack>* tracks);

// Keeps at most `most` tracks: those seen by both lenses, which are rare, and an evenly spaced
// subset of the others.
void thin_tracks(std::size_t most, std::vector<BundleTrack>* tracks);

}  // namespace raywalk::calibrate
