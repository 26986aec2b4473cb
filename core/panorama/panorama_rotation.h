// Turns a captured panorama into world axes. rotation.svg shows the three angles.
//
// A frame's rotation R = Ry(yaw) Rx(pitch) Rz(roll) maps camera directions to world directions
// (world_from_camera in core/geometry/sphere.h). The packed panorama shows in world direction d
// what the camera saw there, which is its own direction R^T d.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core/mat.hpp>

namespace raywalk {

// `panorama` is CV_8UC3, width = 2 * height; the result has the same size. Sampled with Catmull-Rom
// cubics, continued across the seam and over the poles.
cv::Mat rotate_panorama(const cv::Mat& panorama, const Eigen::Matrix3d& world_from_camera);

// The same with the colours changed before they are rounded to whole levels. `change` gets levels
// as sampled: cubics overshoot [0, 255] a little.
using ColourChange = std::function<cv::Vec3f(const cv::Vec3f&)>;
cv::Mat rotate_panorama(const cv::Mat& panorama, const Eigen::Matrix3d& world_from_camera,
                        const ColourChange& change);

// `map` is CV_16UC1, a distance map. Takes the nearest pixel, as a mean of distances across an edge
// lies on no surface; distances along the ray do not change with rotation.
cv::Mat rotate_distance_map(const cv::Mat& map, const Eigen::Matrix3d& world_from_camera);

// `mask` is CV_8UC1, 0 = not to be used. Becomes 0 wherever rotate_panorama reads a pixel that is
// 0, so that nothing of what is masked is left in the rotated panorama, and 255 elsewhere.
cv::Mat rotate_mask(const cv::Mat& mask, const Eigen::Matrix3d& world_from_camera);

}  // namespace raywalk
