// The mask of a dual-fisheye frame, through stitching: what one lens hides the other shows where
// both are blended.
#pragma once

#include <opencv2/core/mat.hpp>

#include "calibrate/stitch/stitch_tables.h"

namespace raywalk::calibrate {

// `front` and `back` are the two halves, CV_16SC3 of the tables' size; `mask` is that of the frame
// that holds both image circles, CV_8UC1, 0 = masked. Where both lenses are blended, a pixel that
// reads masked pixels in one of them gets the other's value in both. Returns what is valid of the
// panorama, CV_8UC1 of the tables' size, 0 or 255: 0 where all that a pixel could be read from is
// masked, if only in part.
cv::Mat join_masked_halves(const StitchTables& tables, const cv::Mat& mask, cv::Mat* front,
                           cv::Mat* back);

}  // namespace raywalk::calibrate
