// Connected groups of frames that share scene points, and what of adjusted poses is kept by them.
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

// Keeps the poses of the largest group of frames that scene points connect and that have enough
// observations, and the inliers among their observations, and sets their sigmas. Leaves no
// observations where there is no such group.
void settle(RefinedPoses* refined, const PoseAnchor& anchor);

}  // namespace raywalk::calibrate
