// How well the poses of a bundle adjustment are known against each other.
#pragma once

#include "calibrate/poses/refine_poses.h"

namespace raywalk::calibrate {

// Sets position_sigma_mm and rotation_sigma_deg of every pose: the root mean square over the axes.
// From the normal equations of the observations, weighted as their loss does, with the points
// eliminated and the common frame and scale held, which pictures cannot tell (free-network
// adjustment). Where a point is found depends on what it looks like, so its errors in neighbouring
// panoramas resemble each other: only errors of different points are taken as independent, and
// their spread is that of the pulls which whole points exert (cluster-robust covariance, Liang and
// Zeger 1986). With very many frames (over 500) each pose's own block alone is inverted, which
// takes the other poses for known.
void set_sigmas(RefinedPoses* refined, const PoseAnchor& anchor);

}  // namespace raywalk::calibrate
