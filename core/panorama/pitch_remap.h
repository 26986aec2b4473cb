// The yardstick that views are timed against: one cv::remap of a panorama of their size.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// Pitches a panorama of noise, `width` x `width` / 2 pixels, by 30 degrees, so that neither rows
// nor columns are read in order.
class PitchRemap {
 public:
  explicit PitchRemap(int width);
  void run();

 private:
  cv::Mat source_, map_u_, map_v_, result_;
};

}  // namespace raywalk
