#include "core/panorama/panorama_rotation.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/panorama/panorama_sampler.h"

namespace raywalk {
namespace {

// Calls write(u, v, position) for every output pixel with the camera's pixel position of its world
// direction. R^T d = cos(phi) R^T (sin theta, 0, cos theta) + sin(phi) R^T (0, 1, 0): one matrix
// product per column.
template <typename Write>
void for_each_source(cv::Size size, const Eigen::Matrix3d& world_from_camera, const Write& write) {
  const PanoramaSize panorama{size.width, size.height};
  const Eigen::Matrix3d camera_from_world = world_from_camera.transpose();
  std::vector<Eigen::Vector3d> horizon;
  for (int u = 0; u < size.width; ++u) {
    const double theta = angles_from_pixel({static_cast<double>(u), 0.0}, panorama).theta_rad;
    horizon.push_back(camera_from_world * direction_from_angles({theta, 0.0}));
  }
  for (int v = 0; v < size.height; ++v) {
    const double phi = angles_from_pixel({0.0, static_cast<double>(v)}, panorama).phi_rad;
    const Eigen::Vector3d upward = std::sin(phi) * camera_from_world.col(1);
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector3d direction = std::cos(phi) * horizon[static_cast<size_t>(u)] + upward;
      write(u, v, pixel_from_angles(angles_from_direction(direction), panorama));
    }
  }
}

// Rows and columns that cubic interpolation reads beyond each border.
constexpr int kMaskBorder = 2;

}  // namespace

cv::Mat rotate_panorama(const cv::Mat& panorama, const Eigen::Matrix3d& world_from_camera) {
  const PanoramaSampler source(panorama);
  cv::Mat rotated(panorama.size(), CV_8UC3);
  for_each_source(panorama.size(), world_from_camera, [&](int u, int v, PixelPosition position) {
    const cv::Vec3f colour = source.at(position);
    rotated.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(colour[0]),
                                   cv::saturate_cast<uchar>(colour[1]),
                                   cv::saturate_cast<uchar>(colour[2])};
  });
  return rotated;
}

cv::Mat rotate_distance_map(const cv::Mat& map, const Eigen::Matrix3d& world_from_camera) {
  cv::Mat rotated(map.size(), CV_16UC1);
  for_each_source(map.size(), world_from_camera, [&](int u, int v, PixelPosition position) {
    rotated.at<ushort>(v, u) = map.at<ushort>(nearest_pixel(position, map.size()));
  });
  return rotated;
}

cv::Mat rotate_mask(const cv::Mat& mask, const Eigen::Matrix3d& world_from_camera) {
  // Cubic interpolation between pixels 0 and 1 reads pixels -1 to 2: an erosion takes the minimum
  // of these for all positions at once.
  const cv::Mat footprint = cv::Mat::ones(4, 4, CV_8UC1);
  cv::Mat least;
  cv::erode(with_wrapped_border(mask, kMaskBorder), least, footprint, {1, 1});
  cv::Mat rotated(mask.size(), CV_8UC1);
  for_each_source(mask.size(), world_from_camera, [&](int u, int v, PixelPosition position) {
    const int left = static_cast<int>(std::floor(position.u));
    const int upper = static_cast<int>(std::floor(position.v));
    rotated.at<uchar>(v, u) =
        least.at<uchar>(upper + kMaskBorder, left + kMaskBorder) == 0 ? 0 : 255;
  });
  return rotated;
}

double masked_share(const cv::Mat& mask) {
  double share = 0.0;
  for (int v = 0; v < mask.rows; ++v) {
    const double phi =
        angles_from_pixel({0.0, static_cast<double>(v)}, {mask.cols, mask.rows}).phi_rad;
    const int hidden = mask.cols - cv::countNonZero(mask.row(v));
    share += hidden * std::cos(phi) * kHalfPi / (static_cast<double>(mask.cols) * mask.rows);
  }
  return share;
}

}  // namespace raywalk
