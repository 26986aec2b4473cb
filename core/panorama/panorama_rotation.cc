#include "build_lf/frame_rotation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// Rows and columns a cubic reads beyond the image on each side.
constexpr int kBorder = 2;

// The pixel where (u, v) really is when it lies beyond the image: columns wrap at the seam; a row
// beyond a pole is the mirrored row, seen half a turn away.
cv::Point wrapped(int u, int v, cv::Size size) {
  if (v < 0 || v >= size.height) {
    v = v < 0 ? -1 - v : 2 * size.height - 1 - v;
    u += size.width / 2;
  }
  return {((u % size.width) + size.width) % size.width, std::clamp(v, 0, size.height - 1)};
}

cv::Mat with_border(const cv::Mat& image) {
  cv::Mat bordered(image.rows + 2 * kBorder, image.cols + 2 * kBorder, image.type());
  for (int v = 0; v < bordered.rows; ++v) {
    for (int u = 0; u < bordered.cols; ++u) {
      bordered.at<cv::Vec3b>(v, u) =
          image.at<cv::Vec3b>(wrapped(u - kBorder, v - kBorder, image.size()));
    }
  }
  return bordered;
}

// Catmull-Rom weights of the samples at -1, 0, 1, 2 for a position t in [0, 1): the cubic through
// the inner two whose slopes there are the central differences.
std::array<float, 4> cubic_weights(float t) {
  return {t * (-0.5F + t * (1.0F - 0.5F * t)), 1.0F + t * t * (-2.5F + 1.5F * t),
          t * (0.5F + t * (2.0F - 1.5F * t)), t * t * (-0.5F + 0.5F * t)};
}

cv::Vec3b sample_cubic(const cv::Mat& bordered, PixelPosition position) {
  const int u = static_cast<int>(std::floor(position.u));
  const int v = static_cast<int>(std::floor(position.v));
  const std::array<float, 4> across = cubic_weights(static_cast<float>(position.u - u));
  const std::array<float, 4> down = cubic_weights(static_cast<float>(position.v - v));
  cv::Vec3f sum(0, 0, 0);
  for (int row = 0; row < 4; ++row) {
    const cv::Vec3b* pixels = bordered.ptr<cv::Vec3b>(v - 1 + row + kBorder) + u - 1 + kBorder;
    cv::Vec3f along(0, 0, 0);
    for (int column = 0; column < 4; ++column) {
      along += across[static_cast<size_t>(column)] * cv::Vec3f(pixels[column]);
    }
    sum += down[static_cast<size_t>(row)] * along;
  }
  return {cv::saturate_cast<uchar>(sum[0]), cv::saturate_cast<uchar>(sum[1]),
          cv::saturate_cast<uchar>(sum[2])};
}

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

}  // namespace

cv::Mat rotate_panorama(const cv::Mat& panorama, const Eigen::Matrix3d& world_from_camera) {
  const cv::Mat source = with_border(panorama);
  cv::Mat rotated(panorama.size(), CV_8UC3);
  for_each_source(panorama.size(), world_from_camera, [&](int u, int v, PixelPosition position) {
    rotated.at<cv::Vec3b>(v, u) = sample_cubic(source, position);
  });
  return rotated;
}

cv::Mat rotate_distance_map(const cv::Mat& map, const Eigen::Matrix3d& world_from_camera) {
  cv::Mat rotated(map.size(), CV_16UC1);
  for_each_source(map.size(), world_from_camera, [&](int u, int v, PixelPosition position) {
    const int nearest_u = static_cast<int>(std::lround(position.u));
    const int nearest_v = static_cast<int>(std::lround(position.v));
    rotated.at<ushort>(v, u) = map.at<ushort>(wrapped(nearest_u, nearest_v, map.size()));
  });
  return rotated;
}

}  // namespace raywalk
