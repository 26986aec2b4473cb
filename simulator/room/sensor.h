// Camera model behind the rays: illumination by the lenses, gain, clipping and noise.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "core/geometry/fisheye_lens.h"
#include "simulator/room/room_settings.h"

namespace raywalk::simulator {

// The picture (CV_8UC3, sRGB) exposed with a relative `gain` and read out with noise. The gain
// multiplies linear light, which is clipped at white. The noise is normally distributed and
// independent in every pixel and channel; its standard deviation at level L (0..255, after the
// gain) is sqrt(noise_levels^2 + shot_noise L). It is determined by `key`. If `light` is given
// (CV_32FC1 of the picture's size), each pixel's gain is multiplied by its value. Throws Error if
// the image or `light` has another type or size or the gain is not positive, Interrupted.
cv::Mat apply_sensor(const cv::Mat& image, const SensorSettings& sensor, double gain,
                     std::uint64_t key, const cv::Mat& light = {});

// Vignetting and different exposure of the two lenses of a dual-fisheye frame.
struct LensLightSettings {
  double vignetting = 0.0;    // relative light loss at the rim, 0 to 0.9
  double lens_gain_ev = 0.0;  // exposure of the back lens relative to the front one

  bool is_even() const { return vignetting == 0.0 && lens_gain_ev == 0.0; }
};

// CV_32FC1, the factor of each pixel's linear light; 1 on the front lens's axis and outside the
// circles. With t the angle from a lens's axis, T that of its rim and s = (t / T)^2, it is
// 1 - vignetting (s + s^2) / 2: a polynomial up to the fourth power of the angle, as the series of
// the cos^4 law begins. The lenses are such as DualFisheyeRays takes.
cv::Mat lens_light(const DualFisheyeLayout& layout, PanoramaSize frame,
                   const LensLightSettings& settings);

}  // namespace raywalk::simulator
