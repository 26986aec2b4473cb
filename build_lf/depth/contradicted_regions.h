// Regions of contradicted pixels.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk::build_lf {

// Grey levels by which a colour must lie outside what others show.
struct GapLimits {
  float weak = 0.0f;    // belongs to a region
  float strong = 0.0f;  // makes a region
};

// The regions (CV_8UC1, 255) of `gaps`, a transposed panorama (row = theta, column = phi) of
// CV_32FC1: how far each pixel's colour lies outside what others show; 0 where they agree or are
// not known. A region is at least five pixels wide somewhere and has enough strong pixels; it is
// widened by the pixels that are mixed with it.
cv::Mat contradicted_regions(const cv::Mat& gaps, GapLimits limits);

}  // namespace raywalk::build_lf
