// What no station shows of a picture, filled from the rest of it.
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "core/room/line_volume.h"
#include "core/view/unknown_pixels.h"

namespace raywalk {

// The unknown rows of a column, from the top; they may overlap.
using UnknownRows = std::vector<RowRun>;

// What is unknown of a panorama, or of consecutive columns of one.
struct UnknownPixels {
  std::span<const UnknownRows> columns;
  Seam seam = Seam::kOpen;
  RowRun rows{};   // that are rendered: the others are not looked at
  int height = 0;  // of the columns
};

// Fills the unknown pixels of a picture (CV_8UC3, fill_unknown). Only what is around them is looked
// at, so that a few cost little. A picture of which nothing is known is left as it is.
void fill_picture(const UnknownPixels& unknown, cv::Mat* picture);

// Whether something of at least `size_px` columns or rows is unknown at the border of the part, so
// that what surrounds it is only partly in it.
bool is_unknown_at_border(const UnknownPixels& unknown, int size_px);

}  // namespace raywalk
