// Images for the tests of the metrics. All are CV_8UC3 and deterministic.
#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace raywalk {

inline cv::Mat flat_image(cv::Size size, const cv::Scalar& bgr) { return {size, CV_8UC3, bgr}; }

// Smooth coloured waves, boxes and lines: gradients, edges and texture in one.
inline cv::Mat textured_image(cv::Size size) {
  cv::Mat image(size, CV_8UC3);
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      const double waves =
          std::sin(0.13 * col) * std::cos(0.09 * row) + std::sin(0.011 * col * row);
      image.at<cv::Vec3b>(row, col) = {
          cv::saturate_cast<std::uint8_t>(120 + 45 * waves),
          cv::saturate_cast<std::uint8_t>(110 + 60.0 * row / size.height),
          cv::saturate_cast<std::uint8_t>(90 - 30 * waves)};
    }
  }
  const cv::Rect box(size.width / 5, size.height / 4, size.width / 4, size.height / 3);
  cv::rectangle(image, box, cv::Scalar(30, 200, 240), cv::FILLED);
  cv::line(image, {0, size.height - 1}, {size.width - 1, size.height / 2}, cv::Scalar(250, 20, 10));
  return image;
}

// With Gaussian noise of the given standard deviation in 8-bit levels.
inline cv::Mat noisy(const cv::Mat& image, double deviation, int seed = 1) {
  cv::Mat noise(image.size(), CV_64FC3);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, deviation);
  cv::Mat sum;
  cv::add(image, noise, sum, cv::noArray(), CV_8U);
  return sum;
}

inline cv::Mat blurred(const cv::Mat& image, double sigma_px) {
  cv::Mat out;
  cv::GaussianBlur(image, out, cv::Size(), sigma_px);
  return out;
}

// Multiplied by gain, offset added, rounded and cut off at 0 and 255.
inline cv::Mat adjusted(const cv::Mat& image, double gain, double offset) {
  cv::Mat out;
  image.convertTo(out, CV_8U, gain, offset);
  return out;
}

// Rotated about the vertical: columns move to the right and wrap around.
inline cv::Mat rolled(const cv::Mat& image, int columns) {
  const int kept = image.cols - columns;
  cv::Mat out;
  cv::hconcat(image.colRange(kept, image.cols), image.colRange(0, kept), out);
  return out;
}

}  // namespace raywalk
