// A station's panorama as an OpenCV image, for filters and optical flow.
//
// Images here are transposed, as the rays are stored: row = theta (u), column = phi (v), so a row
// holds a panorama's column from top to bottom.
#pragma once

#include <opencv2/core/mat.hpp>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The panorama of a station, CV_8UC3 in the order red, green, blue; reduced to `size` by area
// averaging.
cv::Mat station_image(const Room& room, StationIndex station, PanoramaSize size);

// The valid pixels of station_image(), CV_8UC1: 0 within `margin_px` pixels of a masked ray
// (LineVolume::valid_rows), 255 elsewhere. Empty if the station's line has no masks.
cv::Mat station_validity(const Room& room, StationIndex station, PanoramaSize size, int margin_px);

}  // namespace raywalk::build_lf
