// How bright each pixel of a dual-fisheye frame is for the same light in the room: lenses are
// darker towards their rim, and the two are not exposed alike.
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/geometry/fisheye_lens.h"

namespace raywalk::capture {

struct LensLightSettings {
  double vignetting = 0.0;    // share of the light that is lost at the rim, 0 to 0.9
  double lens_gain_ev = 0.0;  // exposure of the back lens against the front one

  bool operator==(const LensLightSettings&) const = default;
};

// CV_32FC1, the factor of each pixel's linear light; 1 on the front lens's axis. At the angle t
// from a lens's axis, T that of its rim and s = (t / T)^2, it is (1 - vignetting (s + s^2) / 2):
// fourth powers of the angle are what cos^4, the law of a simple lens, begins with. 1 outside of
// the circles. Throws Error as DualFisheyeRays does.
cv::Mat lens_light(const DualFisheyeLayout& layout, PanoramaSize frame,
                   const LensLightSettings& settings);

}  // namespace raywalk::capture
