// Encodes JPEG with or without chroma subsampling; OpenCV 4.6 always writes 4:2:0.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk::capture {

enum class JpegColour {
  kFull,    // 4:4:4
  kQuarter  // 4:2:0: colour at half the width and height, as most cameras store it
};

// The bytes of a JPEG file of `image`, BGR in CV_8UC3. `quality` is 1 to 100. Throws Error if the
// image has another type or is larger than the format allows, or if memory runs out.
std::vector<std::byte> encode_jpeg(const cv::Mat& image, int quality,
                                   JpegColour colour = JpegColour::kFull);

}  // namespace raywalk::capture
