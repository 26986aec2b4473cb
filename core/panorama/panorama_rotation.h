// Turns a captured panorama into world axes. rotation.svg shows the three angles.
//
// A frame's rotation R = Ry(yaw) Rx(pitch) Rz(roll) maps camera directions to world directions
// (world_from_camera in core/geometry/sphere.h). The packed panorama shows in world direction d
// what the camera saw there, which is its own direction R^T d.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace raywalk {

// `panorama` is CV_8UC3, width = 2 * height; the result has the same size. Sampled with Catmull-Rom
// cubics, continued across the seam and over the poles.
cv::Mat rotate_panorama(const cv::Mat& panorama, const Eigen::Matrix3d& world_from_camera);

// `map` is CV_16UC1, a distance map. Takes the nearest pixel, as a mean of distances across an edge
// lies on no surface; distances along the ray do not change with rotation.
cv::Mat rotate_distance_map(const cv::Mat& map, const Eigen::Matrix3d& world_from_camera);

}  // namespace raywalk
