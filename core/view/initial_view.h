// Initial views: the vertical cut through the light field. A column is that of the stations around
// the point where it meets a line, in the same direction, mixed by nearness. Without distances
// masked rows cannot be read from where another line shows the point: they count as unread.
//
// Where output columns coincide with captured columns, 3 bytes are read in sequence per row and
// station; else one sample each.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/room/room.h"
#include "core/view/exposure.h"
#include "core/view/rendered_part.h"
#include "core/view/view_options.h"
#include "core/view/visibility.h"

namespace raywalk {

struct InitialView {
  const Room& room;
  const ViewOptions& options;
  const Exposure* exposure = nullptr;  // null: all stations agree
  Visibility::Sources sources{};
  PanoramaSize output{};
};

// Renders `count` columns of the output from `first` on, around the seam, and rows [rows.begin,
// rows.end), bgr, to `image` (CV_8UC3), whose upper left corner is that of the block.
void render_initial(const InitialView& view, int first, int count, RowRun rows, cv::Mat image,
                    std::vector<UnreadRows>* unread, PixelCounts* counts);

}  // namespace raywalk
