#include "core/evaluate/metrics/luma.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace raywalk {

cv::Mat luma_8bit(const cv::Mat& bgr) {
  cv::Mat luma;
  cv::cvtColor(bgr, luma, cv::COLOR_BGR2GRAY);
  return luma;
}

cv::Mat luma_unrounded(const cv::Mat& bgr) {
  cv::Mat samples;
  bgr.convertTo(samples, CV_64F);
  cv::Mat luma;
  // cvtColor does not take double.
  cv::transform(samples, luma, cv::Matx13d(0.114, 0.587, 0.299));
  return luma;
}

}  // namespace raywalk
