// How an export's pictures are written.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "core/files/atomic_output.h"
#include "core/files/jpeg.h"

namespace raywalk::render {

// Of libjpeg: the loss is hardly visible, at a tenth of the bytes.
inline constexpr int kWebJpegQuality = 90;

inline void write_jpeg(const std::filesystem::path& file, const cv::Mat& picture) {
  write_file_atomically(file, encode_jpeg(picture, kWebJpegQuality));
}

}  // namespace raywalk::render
