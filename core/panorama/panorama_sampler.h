// Samples a panorama at subpixel positions.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/geometry/sphere.h"

namespace raywalk {

// The pixel of (u, v), which may lie up to one image size outside the panorama: columns wrap at the
// seam; a row beyond a pole is the mirrored row, half a turn away.
cv::Point wrapped_pixel(int u, int v, cv::Size size);

// The panorama, of any type, with `border_px` pixels around it that are those of wrapped_pixel.
// At most as wide as the panorama is high.
cv::Mat with_wrapped_border(const cv::Mat& panorama, int border_px);

// The pixel of a panorama of `size`, width = 2 * height, whose centre is nearest to a position (any
// that pixel_from_angles returns), or to where a direction of the camera's frame, not zero, lies.
cv::Point nearest_pixel(PixelPosition position, cv::Size size);
cv::Point nearest_pixel(const Eigen::Vector3d& direction, cv::Size size);

// Samples with Catmull-Rom cubics in floating point, continued across the seam and over the poles.
// Safe to use from several threads at once.
class PanoramaSampler {
 public:
  // `panorama` is CV_8UC3, width = 2 * height; it is copied.
  explicit PanoramaSampler(const cv::Mat& panorama);

  PanoramaSize size() const { return size_; }
  // Channels in the panorama's order, in [0, 255] up to cubic overshoot. Accepts any position that
  // pixel_from_angles returns.
  cv::Vec3f at(PixelPosition position) const;
  // The colour in a direction (nonzero) of the camera's frame.
  cv::Vec3f at(const Eigen::Vector3d& direction) const {
    return at(pixel_from_angles(angles_from_direction(direction), size_));
  }

 private:
  PanoramaSize size_;
  cv::Mat bordered_;
};

}  // namespace raywalk
