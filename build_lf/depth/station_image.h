// A station's panorama as an image that OpenCV's filters and flows can work on.
//
// Images here are transposed, as the rays are stored: row = theta (u), column = phi (v), so a row
// holds a panorama's column from top to bottom.
#pragma once

#include <opencv2/core/mat.hpp>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The panorama of a station, CV_8UC3 in the order red, green, blue; reduced to `size` by the mean
// over the area of each pixel.
cv::Mat station_image(const Room& room, StationIndex station, PanoramaSize size);

// Which pixels of station_image() may be used, CV_8UC1: 0 where a masked ray
// (LineVolume::valid_rows) is not farther than `margin_px` pixels, 255 elsewhere. Empty where the
// station's line has no masks.
cv::Mat station_validity(const Room& room, StationIndex station, PanoramaSize size, int margin_px);

}  // namespace raywalk::build_lf
