// Metrics of a pair of images computed by ffmpeg's filters; for tests.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

namespace raywalk {

// Runs `ffmpeg -lavfi FILTER` (psnr or ssim) on both images, handed over as raw gray (CV_8UC1) or
// bgr24 (CV_8UC3) frames, and returns the number it prints behind "KEY:". `options` go before the
// inputs. Throws std::runtime_error with ffmpeg's output if it fails, is missing or prints no such
// number.
double ffmpeg_filter_value(const std::string& filter, const std::string& key, const cv::Mat& a,
                           const cv::Mat& b, const std::string& options = "");

}  // namespace raywalk
