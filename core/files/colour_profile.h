// The colours that an image file means by its pixel values.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

namespace raywalk {

// The ICC profile embedded in a JPEG file (ICC.1:2010, annex B.4) or PNG file (chunk iCCP), or in
// as much of its beginning as lies before the pixels. Empty if there is none, or it is damaged.
std::string embedded_profile(std::span<const std::byte> file);

// Changes an image (CV_8UC3, BGR) whose values are meant as `profile` says to sRGB, which is what
// views are shown in. Does nothing for a profile that is sRGB to within a grey level, is not one of
// RGB, or cannot be read.
void convert_to_srgb(const std::string& profile, cv::Mat* image);

}  // namespace raywalk
