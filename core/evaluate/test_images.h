// Images for the tests of the metrics. All are CV_8UC3 and deterministic.
#pragma once

#include <opencv2/core/mat.hpp>

namespace raywalk {

cv::Mat flat_image(cv::Size size, const cv::Scalar& bgr);
// Smooth coloured waves, boxes and lines: gradients, edges and texture in one.
cv::Mat textured_image(cv::Size size);
// With Gaussian noise of the given standard deviation in 8-bit levels.
cv::Mat noisy(const cv::Mat& image, double deviation, int seed = 1);
cv::Mat blurred(const cv::Mat& image, double sigma_px);
// Multiplied by gain, offset added, rounded and cut off at 0 and 255.
cv::Mat adjusted(const cv::Mat& image, double gain, double offset);
// Rotated about the vertical: columns move to the right and wrap around.
cv::Mat rolled(const cv::Mat& image, int columns);

}  // namespace raywalk
