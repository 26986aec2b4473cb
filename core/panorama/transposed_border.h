// Borders of a transposed panorama (row = theta, column = phi), for image filters and optical flow
// that do not handle the sphere's wrap-around.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

// The image with `border_px` more pixels on every side, at most its size in phi: theta wraps around
// the sphere; at the poles the image is mirrored.
cv::Mat with_border(const cv::Mat& image, int border_px);

// The inverse: a bordered image (of any type) without its border; shares the memory.
cv::Mat without_border(const cv::Mat& bordered, int border_px);

}  // namespace raywalk
