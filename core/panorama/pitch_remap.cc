#include "core/panorama/pitch_remap.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/geometry/sphere.h"

namespace raywalk {

PitchRemap::PitchRemap(int width)
    : source_(width / 2, width, CV_8UC3),
      map_u_(source_.size(), CV_32FC1),
      map_v_(source_.size(), CV_32FC1) {
  cv::randu(source_, 0, 256);
  const PanoramaSize size{source_.cols, source_.rows};
  const Eigen::Matrix3d pitch = world_from_camera({.pitch_rad = radians_from_degrees(30.0)});
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const SphereAngles angles = angles_from_pixel({double(u), double(v)}, size);
      const PixelPosition from =
          pixel_from_angles(angles_from_direction(pitch * direction_from_angles(angles)), size);
      map_u_.at<float>(v, u) = static_cast<float>(from.u);
      map_v_.at<float>(v, u) = static_cast<float>(from.v);
    }
  }
}

void PitchRemap::run() {
  cv::remap(source_, result_, map_u_, map_v_, cv::INTER_LINEAR, cv::BORDER_WRAP);
}

}  // namespace raywalk
