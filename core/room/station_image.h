// A station's panorama as an OpenCV image, for filters and optical flow.
//
// Images here are transposed, as the rays are stored: row = theta (u), column = phi (v), so a row
// holds a panorama's column from top to bottom.
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/geometry/grid.h"
#include "core/room/room.h"

namespace raywalk {

// What a station captured, without gains: CV_8UC3, red, green, blue.
cv::Mat captured_columns(const LineVolume& volume, int station);

// Its mask: CV_8UC1, 0 = masked, else 255 (LineVolume::valid_rows); empty where no station of the
// line has one.
cv::Mat captured_validity(const LineVolume& volume, int station);

// captured_columns(), reduced to `size` by area averaging.
cv::Mat station_image(const Room& room, StationIndex station, PanoramaSize size);

// The valid pixels of station_image(), CV_8UC1: 0 within `margin_px` pixels of a masked ray, 255
// elsewhere. Empty if the station's line has no masks.
cv::Mat station_validity(const Room& room, StationIndex station, PanoramaSize size, int margin_px);

}  // namespace raywalk
