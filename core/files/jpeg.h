// JPEG files, decoded and encoded with TurboJPEG.
//
// OpenCV decodes them with the same library to the same pixels, but goes on where data are missing
// and returns an image whose rest is grey.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

namespace raywalk {

enum class JpegSampling {
  kFull,    // 4:4:4
  kQuarter  // 4:2:0: colour at half the width and height, as most cameras store it
};

struct JpegHeader {
  int width = 0;  // at least 1
  int height = 0;
  bool is_grey = false;
};

// From the beginning of a file, as far as its first scan. Throws Error naming `source` if that is
// damaged or not there.
JpegHeader read_jpeg_header(std::span<const std::byte> bytes, const std::string& source);

// The image in a whole JPEG file, as stored, of `type` CV_8UC3 (BGR, also of grey images) or
// CV_8UC1 (the luminance of a colour image): EXIF orientation is ignored. Throws Error naming
// `source`: damaged or cut short as far as libjpeg can tell (JPEG has no checksums), over 2^30
// pixels, CMYK, 12 bits per channel. Stray bytes between its parts, which some cameras leave, are
// no damage. Prints nothing.
cv::Mat decode_jpeg(std::span<const std::byte> bytes, int type, const std::string& source);

// Throws the errors of decode_jpeg. Faster, as only one pixel of each block is computed.
void require_intact_jpeg(std::span<const std::byte> bytes, const std::string& source);

// "SOURCE: the image is damaged or cut short (REASON); capture or copy it again".
[[noreturn]] void throw_damaged_image(const std::string& source, const std::string& reason);

// A colour image (CV_8UC3, BGR) as a JPEG file. `quality` is libjpeg's, 1 to 100. Throws Error for
// an image that is empty, of another type or larger than JPEG holds (65500 pixels).
std::vector<std::byte> encode_jpeg(const cv::Mat& image, int quality,
                                   JpegSampling sampling = JpegSampling::kFull);

}  // namespace raywalk
