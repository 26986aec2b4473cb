// What of adjusted poses is kept, and how sure it is.
#pragma once

#include "calibrate/poses/refine_poses.h"

namespace raywalk::calibrate {

// Keeps the poses of the largest group of frames that scene points connect and that have enough
// observations, and the inliers among their observations, and sets their sigmas. Leaves no
// observations where there is no such group.
void settle(RefinedPoses* refined, const PoseAnchor& anchor);

}  // namespace raywalk::calibrate
