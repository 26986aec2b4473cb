// A look at the pictures before hours are spent: do they move as the frame list says?
//
// Between two stations of a line every surface moves away from the direction of travel, by an angle
// that grows with its nearness. So a station's picture can be made from the other one's by some
// distance in every pixel, if the direction of travel is the true one; by a wrong direction it
// cannot. Lists that are mirrored, turned, reversed or have axes exchanged are found by trying the
// four directions of the plan's axes.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <string>

#include "build_lf/pack/pack_plan.h"

namespace raywalk::build_lf {

// +x, -x, +z, -z.
inline constexpr int kDirections = 4;
using DirectionCosts = std::array<double, kDirections>;

// What is left of the difference of two panoramas in world axes, CV_8UC3, 2:1, at least 256 wide,
// when the camera travelled along each direction from the first to the second: 1 if that direction
// explains nothing, 0 if all. All 1 for pictures that are equal.
DirectionCosts costs_of_travel(const cv::Mat& first, const cv::Mat& second);

// Throws Error that names what is likely wrong with the list where the pictures clearly move along
// other axes than listed: on all lines along an axis, or on single ones. Plain, dark and far scenes
// say nothing, nor do panoramas less than 256 wide.
void require_listed_motion(const PackPlan& plan, const std::string& list);

}  // namespace raywalk::build_lf
