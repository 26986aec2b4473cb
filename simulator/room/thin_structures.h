// Where a view shows thin structures: chair legs, spindles, cords, railings.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk::capture {

// From the distance map of a panorama (CV_32FC1, metres, +inf for the sky): 255 where something is
// seen that is narrower than 3 degrees across and at least a tenth nearer than what is on both
// sides of it, and in the pixels around it; else 0. CV_8UC1.
cv::Mat thin_structures(const cv::Mat& distance_m);

}  // namespace raywalk::capture
