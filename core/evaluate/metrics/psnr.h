// Peak signal-to-noise ratio over the three colour channels, plain and weighted by solid angle.
//
// Images are CV_8UC3 of equal size (any channel order: all channels have the same weight). A mask
// is empty (every pixel counts) or CV_8UC1 of the images' size; pixels where it is not 0 count. All
// functions throw Error otherwise, for empty images, and for a mask that selects no pixel.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// PSNR of identical pictures is infinite, which JSON cannot represent and a mean cannot use: scores
// are clamped to this. An 8-bit picture that differs at all is rarely above 90 dB.
inline constexpr double kMaxPsnrDb = 100.0;

// Mean of (a - b)^2 over all channels of the pixels that count; in squared 8-bit levels, 0..65025.
// Columns are selected by passing a.colRange(...).
double mean_squared_error(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask = cv::Mat());

// 10 log10(255^2 / mean_squared_error) in dB; +infinity for an error of 0.
double psnr_db(double mean_squared_error);

// The PSNR of two images in dB; +infinity for identical images, 0 at worst. This is the `average`
// of ffmpeg's psnr filter for RGB input.
double psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask = cv::Mat());

// WS-PSNR in dB (Sun, Lu, Yu: Weighted-to-Spherically-Uniform Quality Evaluation for
// Omnidirectional Video, IEEE Signal Processing Letters 24(9), 2017): as psnr_db, with every row
// weighted by cos(phi) at its pixel centres, the solid angle its pixels cover. The images are whole
// panoramas.
double ws_psnr_db(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask = cv::Mat());

}  // namespace raywalk
