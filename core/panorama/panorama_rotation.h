// Rotates a captured panorama into world axes. rotation.svg shows the three angles.
//
// A frame's rotation R = Ry(yaw) Rx(pitch) Rz(roll) maps camera directions to world directions
// (world_from_camera in core/geometry/sphere.h). The packed panorama in world direction d is
// sampled from camera direction R^T d.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace raywalk {

// `panorama` is CV_8UC3, width = 2 * height; the result has the same size. Catmull-Rom cubic
// interpolation, continued across the seam and over the poles.
cv::Mat rotate_panorama(const cv::Mat& panorama, const Eigen::Matrix3d& world_from_camera);

// `map` is a distance map, CV_16UC1. Nearest-pixel sampling, as interpolation across an edge would
// give distances on no surface. Distances along the ray do not change with rotation.
cv::Mat rotate_distance_map(const cv::Mat& map, const Eigen::Matrix3d& world_from_camera);

// `mask` is CV_8UC1, 0 = invalid. The result is 0 wherever rotate_panorama would read a masked
// pixel, 255 elsewhere, so no masked content remains valid in the rotated panorama.
cv::Mat rotate_mask(const cv::Mat& mask, const Eigen::Matrix3d& world_from_camera);

// Share of the sphere that a mask of a panorama hides, 0 to 1.
double masked_share(const cv::Mat& mask);

}  // namespace raywalk
