// The dolly under a simulated camera, in every picture that it takes.
#pragma once

#include <opencv2/core/mat.hpp>

#include "capture/simulated/virtual_room/pixel_rays.h"

namespace raywalk::capture {

struct DollySettings {
  bool visible = false;
  // How far from straight down the middle of its platform's edges is seen; corners and wheels reach
  // further. 10 to 45; less would show the pole beside it.
  double reach_deg = 20.0;
};

// A plate right under the camera, a pole, a square platform on four wheels that stand on the floor,
// and a short piece of rail. All of it is still in the camera's frame, whatever the carriage does,
// so what covers a picture is worked out once. Its light is its own: it neither casts shadows in
// the room nor shows in the mirror, and nothing of the room comes between it and the camera.
class DollyView {
 public:
  // The floor is `floor_m` under the camera; all sizes are in proportion to it. Throws Error where
  // that is not positive.
  DollyView(const PixelRays& camera, const DollySettings& dolly, double floor_m);

  // CV_32FC1, the share of each pixel that the dolly covers, 0 to 1: the mean over 4 x 4 rays.
  const cv::Mat& share() const { return share_; }
  // Puts the dolly into the camera's picture (CV_8UC3, sRGB), mixing linear light. Throws Error for
  // a picture of another size or type.
  void cover(cv::Mat* picture) const;

 private:
  cv::Mat share_;  // CV_32FC1
  cv::Mat light_;  // CV_32FC3 in the picture's order, linear, times the share
};

}  // namespace raywalk::capture
