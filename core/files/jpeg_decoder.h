// Decodes JPEG files, taking every warning of the decoder for damage.
//
// OpenCV decodes them with the same library to the same pixels, but goes on after a warning and
// returns a picture whose rest is destroyed. JPEG has no checksums: what else shows damage is
// looked for too (jpeg_scan_check.h), and some damage shows by nothing.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

namespace raywalk {

enum class JpegColours {
  kBgr,   // CV_8UC3, also of grey and CMYK pictures
  kGrey,  // CV_8UC1, the luminance of a colour picture; not of CMYK pictures
};

// The picture in a whole JPEG file, as stored: EXIF orientation is ignored. Throws Error naming
// `source`: damaged or cut short, more than 2^30 pixels, a kind that libjpeg cannot decode (12 bits
// per channel). Prints nothing.
cv::Mat decode_jpeg(std::span<const std::byte> bytes, JpegColours colours,
                    const std::string& source);

// Throws the errors of decode_jpeg. Faster, as pixels are not computed in full.
void require_intact_jpeg(std::span<const std::byte> bytes, const std::string& source);

}  // namespace raywalk
