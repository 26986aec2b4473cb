// Relative illumination of the pixels of a dual-fisheye frame: vignetting and different exposure of
// the two lenses.
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/geometry/fisheye_lens.h"

namespace raywalk::capture {

struct LensLightSettings {
  double vignetting = 0.0;    // relative light loss at the rim, 0 to 0.9
  double lens_gain_ev = 0.0;  // exposure of the back lens relative to the front one

  bool operator==(const LensLightSettings&) const = default;
};

// CV_32FC1, the factor of each pixel's linear light; 1 on the front lens's axis and outside the
// circles. With t the angle from a lens's axis, T that of its rim and s = (t / T)^2, it is
// 1 - vignetting (s + s^2) / 2: a polynomial up to the fourth power of the angle, as the series of
// the cos^4 law begins. Throws Error as DualFisheyeRays does.
cv::Mat lens_light(const DualFisheyeLayout& layout, PanoramaSize frame,
                   const LensLightSettings& settings);

}  // namespace raywalk::capture
