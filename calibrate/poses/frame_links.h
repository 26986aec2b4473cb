// Which frames the pictures hold together.
#pragma once

#include <span>
#include <vector>

#include "calibrate/poses/refine_poses.h"

namespace raywalk::calibrate {

// Frames that share points, as groups; index of the group for each frame, -1 for one that shares
// none. Two frames belong together when the points that both see, or a chain of such frames, are at
// least `least_points` in number.
std::vector<int> linked_groups(int frames, const SeenPoints& points, int least_points);

// The group with the most frames; -1 where there is none.
int largest_group(std::span<const int> groups);

// Points that frames of both sets see.
int common_points(const SeenPoints& points, const std::vector<bool>& a, const std::vector<bool>& b);

// Observations whose error is within `inlier_px`, and the points they see.
SeenPoints inliers_of(const RefinedPoses& refined);

}  // namespace raywalk::calibrate
