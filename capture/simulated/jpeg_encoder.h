// Encodes JPEG without chroma subsampling (4:4:4); OpenCV 4.6 always writes 4:2:0.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk::capture {

// The bytes of a JPEG file of `image`, BGR in CV_8UC3. `quality` is 1 to 100. Throws Error if the
// image has another type or is larger than the format allows, or if memory runs out.
std::vector<std::byte> encode_jpeg(const cv::Mat& image, int quality);

}  // namespace raywalk::capture
