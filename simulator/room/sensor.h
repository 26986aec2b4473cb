// Camera sensor model: gain, clipping and noise.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "simulator/room/room_settings.h"

namespace raywalk::capture {

// The picture (CV_8UC3, sRGB) exposed with a relative `gain` and read out with noise. The gain
// multiplies linear light, which is clipped at white. The noise is normally distributed and
// independent in every pixel and channel; its standard deviation at level L (0..255, after the
// gain) is sqrt(noise_levels^2 + shot_noise L). It is determined by `key`. If `light` is given
// (CV_32FC1 of the picture's size), each pixel's gain is multiplied by its value. Throws Error if
// the image or `light` has another type or size or the gain is not positive, Interrupted.
cv::Mat apply_sensor(const cv::Mat& image, const SensorSettings& sensor, double gain,
                     std::uint64_t key, const cv::Mat& light = {});

}  // namespace raywalk::capture
