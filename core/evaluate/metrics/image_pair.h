// The requirements of every metric on the images it compares.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// Throws Error unless both images are CV_8UC3, of the same size, and at least min_side pixels wide
// and high.
void require_image_pair(const cv::Mat& a, const cv::Mat& b, int min_side);

}  // namespace raywalk
