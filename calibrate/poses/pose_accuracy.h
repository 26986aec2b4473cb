// What of adjusted poses is kept, and the uncertainties of the poses relative to each other.
#pragma once

#include "calibrate/poses/refine_poses.h"

namespace raywalk::calibrate {

// Fewer common scene points do not connect frames or lines: a handful of wrong matches may agree by
// chance.
inline constexpr int kLeastSharedPoints = 15;

// Keeps the poses of the largest group of frames that scene points connect and that have enough
// observations, and the inliers among their observations, and sets their sigmas. Leaves no
// observations where there is no such group.
void settle(RefinedPoses* refined, const PoseAnchor& anchor);

// Sets position_sigma_mm and rotation_sigma_deg of every pose: the root mean square over the axes.
// They follow from the normal equations of the observations, weighted by their loss, with the
// points eliminated and the unobservable common frame and scale fixed (free-network adjustment).
// The errors of a point in neighbouring panoramas are correlated, as they depend on its appearance.
// So only errors of different points are taken as independent, and the covariance is estimated from
// the gradients summed by point (cluster-robust covariance, Liang and Zeger 1986). With over 500
// frames only each pose's own block is inverted, which takes the other poses as known.
void set_sigmas(RefinedPoses* refined, const PoseAnchor& anchor);

}  // namespace raywalk::calibrate
