// Brightness of a colour image: BT.601 luma over the full range,
//   Y = 0.299 R + 0.587 G + 0.114 B,  0..255.
// The same weights ffmpeg uses for gray8, which is full range, unlike the Y of its yuv420p.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// CV_8UC1, rounded to the nearest integer, of a CV_8UC3 image in BGR order.
cv::Mat luma_8bit(const cv::Mat& bgr);

// CV_64FC1, not rounded, of a CV_8UC3 image in BGR order.
cv::Mat luma_unrounded(const cv::Mat& bgr);

}  // namespace raywalk
