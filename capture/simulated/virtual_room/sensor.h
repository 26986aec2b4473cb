// What a camera's electronics do to a perfect picture.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "capture/simulated/virtual_room/room_settings.h"

namespace raywalk::capture {

// The picture (CV_8UC3, sRGB) as exposed with a relative `gain` and read out with noise. The gain
// multiplies linear light; what exceeds white is clipped. The noise is normally distributed and
// independent in every pixel and channel; its standard deviation at level L (0..255, after the
// gain) is sqrt(noise_levels^2 + shot_noise L). `key` chooses the noise: the same key gives the
// same. Where `light` is given (CV_32FC1 of the picture's size), each pixel's gain is multiplied by
// its value. Throws Error for another type of image or a gain that is not positive, Interrupted.
cv::Mat apply_sensor(const cv::Mat& image, const SensorSettings& sensor, double gain,
                     std::uint64_t key, const cv::Mat& light = {});

}  // namespace raywalk::capture
