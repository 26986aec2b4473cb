// The dolly under a simulated camera, visible in all of its pictures.
#pragma once

#include <opencv2/core/mat.hpp>

#include "simulator/room/pixel_rays.h"

namespace raywalk::capture {

struct DollySettings {
  bool visible = false;
  // Angle from the nadir at which the middle of the platform's edges is seen, 10 to 45; corners and
  // wheels extend further. Below 10 the pole would extend beyond the platform.
  double reach_deg = 20.0;
};

// A plate under the camera, a pole, a square platform on four wheels on the floor, and a short
// piece of rail. All of it is fixed in the camera's frame, so it is rendered once and composited
// into each picture. It casts no shadows in the room, is not visible in the mirror, and is never
// occluded.
class DollyView {
 public:
  // The floor is `floor_m` below the camera; all sizes are proportional to it. Throws Error unless
  // it is positive.
  DollyView(const PixelRays& camera, const DollySettings& dolly, double floor_m);

  // CV_32FC1, coverage of each pixel by the dolly, 0 to 1: the mean over 4 x 4 rays.
  const cv::Mat& share() const { return share_; }
  // Composites the dolly into the camera's picture (CV_8UC3, sRGB) in linear light. Throws Error if
  // the picture has another size or type.
  void cover(cv::Mat* picture) const;

 private:
  cv::Mat share_;  // CV_32FC1
  cv::Mat light_;  // CV_32FC3, BGR, linear, premultiplied by the coverage
};

}  // namespace raywalk::capture
