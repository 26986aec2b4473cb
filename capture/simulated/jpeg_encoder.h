// JPEG with colour in full resolution, which OpenCV 4.6 cannot write: it halves it both ways.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk::capture {

// The bytes of a JPEG file (4:4:4) of the picture, BGR in CV_8UC3. `quality` is 1 to 100. Throws
// Error for another type, a picture larger than the format holds, or lack of memory.
std::vector<std::byte> encode_jpeg(const cv::Mat& image, int quality);

}  // namespace raywalk::capture
