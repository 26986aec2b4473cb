// Pass 5, second part: what no station shows of a picture, filled from the rest of it.
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/view/unknown_pixels.h"

namespace raywalk {

// Fills the pixels of a picture (CV_8UC3) where `unread` (of its size) is not 0, connected ones
// together (fill_unknown). Only what is around them is looked at, so that a few cost little. A
// picture of which nothing was read is left as it is.
void fill_picture(const cv::Mat1b& unread, Seam seam, ShownRows rows, cv::Mat* picture);

// Whether something of at least `size_px` columns or rows is unread at the border of the part, so
// that what surrounds it is only partly in it. A joined seam is no border.
bool is_unread_at_border(const cv::Mat1b& unread, Seam seam, ShownRows rows, int size_px);

}  // namespace raywalk
