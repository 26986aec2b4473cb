// Connected groups of frames that share scene points.
#pragma once

#include <span>
#include <vector>

#include "calibrate/poses/refine_poses.h"

namespace raywalk::calibrate {

// The index of each frame's group, -1 for a frame that shares no points. Two frames are linked if
// they share at least `least_points` points; groups are the connected components.
std::vector<int> linked_groups(int frames, const SeenPoints& points, int least_points);

// The group with the most frames; -1 if there is none.
int largest_group(std::span<const int> groups);

// Number of points that are seen by frames of both sets.
int common_points(const SeenPoints& points, const std::vector<bool>& a, const std::vector<bool>& b);

// Observations whose error is within `inlier_px`, and their points.
SeenPoints inliers_of(const RefinedPoses& refined);

}  // namespace raywalk::calibrate
