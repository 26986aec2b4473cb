// The light of the same surfaces in two panoramas whose poses are known.
//
// Around every textured direction of one panorama a small patch is taken. Its distance is unknown;
// it is the one at which the patch, placed there and seen from the other station, correlates best
// with the other panorama. Correlation does not depend on exposure, and a patch is seen at its true
// size from either station, so that neither parallax nor approach enters the ratio of light.
// A patch counts only if the search from the other panorama back leads to where it started.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibrate/rectify/compared_panorama.h"

namespace raywalk::calibrate {

struct MatchedPatch {
  Eigen::Vector3d point_m{0, 0, 0};   // the surface, world frame
  Eigen::Array3d log_ratio{0, 0, 0};  // ln (light in `to` / light in `from`); red, green, blue
  // Standard error of log_ratio, from the part of the patch that does not correlate. Only ratios of
  // errors are to be relied on.
  double error = 1.0;
  double parallax = 0.0;  // baseline / distance
  double ahead = 0.0;     // |cosine| of the angle between view and baseline
  // Directions of the surface in the axes of either camera, unit vectors.
  Eigen::Vector3d seen_from{0, 0, 1}, seen_to{0, 0, 1};
};

// Patches matched from `from` to `to` and the reverse, so that neither panorama is preferred.
std::vector<MatchedPatch> match_patches(const ComparedPanorama& from, const ComparedPanorama& to);

}  // namespace raywalk::calibrate
