// JPEG files from uncompressed frames, two pixels in four bytes: Y0 Cb Y1 Cr (V4L2_PIX_FMT_YUYV).
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

#include "capture/camera/video_device.h"

namespace raywalk::capture {

// The minimum size of a frame of the format in bytes: the last line may lack its padding.
std::size_t min_yuyv_bytes(const VideoFormat& format);

// The frame as BGR in CV_8UC3. `frame` holds at least min_yuyv_bytes(format); the width is even.
cv::Mat bgr_from_yuyv(std::span<const std::byte> frame, const VideoFormat& format);

// The bytes of a JPEG file of the frame; `quality` is 1 to 100. Pixel pairs already share a chroma
// sample, so JPEG's chroma subsampling loses resolution only between lines.
std::string jpeg_from_yuyv(std::span<const std::byte> frame, const VideoFormat& format,
                           int quality);

}  // namespace raywalk::capture
