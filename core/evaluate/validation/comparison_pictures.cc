#include "core/evaluate/validation/comparison_pictures.h"

#include <opencv2/imgproc.hpp>

namespace raywalk {

cv::Mat error_of(const cv::Mat& view, const cv::Mat& truth) {
  cv::Mat error;
  cv::absdiff(view, truth, error);
  error.convertTo(error, -1, kErrorGain);
  return error;
}

cv::Mat shrunk_to(const cv::Mat& image, int width) {
  if (image.cols <= width) return image.clone();
  const int height = static_cast<int>(std::lround(double(image.rows) * width / image.cols));
  cv::Mat shrunk;
  cv::resize(image, shrunk, cv::Size(width, std::max(1, height)), 0, 0, cv::INTER_AREA);
  return shrunk;
}

ViewComparison compare(const cv::Mat& view, const cv::Mat& truth, int width) {
  return {.view = shrunk_to(view, width), .error = shrunk_to(error_of(view, truth), width)};
}

}  // namespace raywalk
