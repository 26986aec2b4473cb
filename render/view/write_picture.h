// Writes a rendered view as a picture file.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "render/view/picture_format.h"
#include "render/view/view_metadata.h"

namespace raywalk::render {

// Writes `image` (CV_8UC3, BGR) with its metadata. Throws Error naming the file; then nothing is
// there.
void write_picture(const std::filesystem::path& file, const cv::Mat& image,
                   const PictureFormat& format, const ViewDescription& view);

}  // namespace raywalk::render
