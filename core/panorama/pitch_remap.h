// The baseline for view timings: one cv::remap of a panorama of the same size.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// Rotates a panorama of noise, `width` x `width` / 2 pixels, by 30 degrees of pitch, so that the
// reads follow neither rows nor columns.
class PitchRemap {
 public:
  explicit PitchRemap(int width);
  void run();

 private:
  cv::Mat source_, map_u_, map_v_, result_;
};

}  // namespace raywalk
