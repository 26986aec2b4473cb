// A station's panorama as an image that OpenCV's filters and flows can work on.
//
// Images here are transposed, as the rays are stored: row = theta (u), column = phi (v), so a row
// holds a panorama's column from top to bottom.
#pragma once

#include <opencv2/core/mat.hpp>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/room/room.h"

namespace raywalk {

// The panorama of a station, CV_8UC3 in the order red, green, blue; reduced to `size` by the mean
// over the area of each pixel.
cv::Mat station_image(const Room& room, StationIndex station, PanoramaSize size);

// The image with `border_px` more pixels on every side, at most as many as it has in phi: theta
// goes on around the sphere; at the poles the image is mirrored, which is what lies there of the
// same column's neighbourhood.
cv::Mat with_border(const cv::Mat& image, int border_px);

// The part of a bordered image (of any type) that lies within the border; shares its memory.
cv::Mat without_border(const cv::Mat& bordered, int border_px);

}  // namespace raywalk
