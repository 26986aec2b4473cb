// Encodes JPEG files with colours at full resolution, which OpenCV before 4.7 cannot.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk {

// A colour picture (CV_8UC3, BGR) as a JPEG file, 4:4:4. `quality` is libjpeg's, 1 to 100. Throws
// Error for a picture that is empty, of another type or larger than JPEG holds (65500 pixels).
std::vector<std::byte> encode_jpeg(const cv::Mat& picture, int quality);

}  // namespace raywalk
