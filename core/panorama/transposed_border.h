// What lies beyond the borders of a transposed panorama (row = theta, column = phi), for filters
// and flows that know no sphere.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// The image with `border_px` more pixels on every side, at most as many as it has in phi: theta
// goes on around the sphere; at the poles the image is mirrored, which is what lies there of the
// same column's neighbourhood.
cv::Mat with_border(const cv::Mat& image, int border_px);

// The part of a bordered image (of any type) that lies within the border; shares its memory.
cv::Mat without_border(const cv::Mat& bordered, int border_px);

}  // namespace raywalk
