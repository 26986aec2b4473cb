// Files embedded in a page as data URIs.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <string_view>

namespace raywalk {

// "data:<media_type>;base64,..." for the bytes of a file of that type.
std::string data_uri(std::span<const unsigned char> bytes, std::string_view media_type);

// Encoding of embedded pictures: PNG is lossless, JPEG (quality 90) far smaller for photographs.
enum class EmbeddedFormat { kPng, kJpeg };

// Encodes an 8-bit image (CV_8UC1, or CV_8UC3 in OpenCV's BGR order). Throws Error for an empty
// image or one of another type.
std::string data_uri(const cv::Mat& image, EmbeddedFormat format);

}  // namespace raywalk
