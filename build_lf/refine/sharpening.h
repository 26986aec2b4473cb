// Undoes the blur that developing causes.
//
// A mean of interpolated samples lacks fine detail: interpolation damps it, and samples that are
// displaced by a part of a pixel do too. How much is measured, not assumed: with B the blur by half
// a captured pixel, the picture M becomes M + s (M - B M), where s is what makes it, seen at the
// captured width as views see it, agree best (least squares) with the station's own photograph,
// which the M compared does not contain.
#pragma once

#include <opencv2/core/mat.hpp>

#include "build_lf/refine/developed_image.h"

namespace raywalk::build_lf {

// s, in [0, 2]; 1 where too little can be compared. `photograph`: CV_8UC3, [theta][phi] like the
// developed picture, which is at most twice as wide, exposure corrected; `comparable`: CV_8UC1 of
// its size, 0 where it cannot be used.
double measured_sharpening(const cv::Mat& others, const cv::Mat& photograph,
                           const cv::Mat1b& comparable);

// The sharpened picture as rays are stored, CV_8UC3; `captured_width` is that of the photographs.
cv::Mat sharpened(const cv::Mat& colour, int captured_width, double amount);

}  // namespace raywalk::build_lf
