#include "simulator/room/thin_structures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace raywalk::capture {
namespace {

constexpr double kWidth_deg = 3.0;
constexpr float kNearer = 0.1F;  // relative, in inverse distance

}  // namespace

cv::Mat thin_structures(const cv::Mat& distance_m) {
  // The longitude wraps around.
  const int side = std::max(static_cast<int>(std::lround(distance_m.cols * kWidth_deg / 360.0)), 3);
  cv::Mat inverse(distance_m.size(), CV_32FC1), around;
  std::transform(distance_m.begin<float>(), distance_m.end<float>(), inverse.begin<float>(),
                 [](float metres) { return std::isinf(metres) ? 0.0F : 1.0F / metres; });
  cv::copyMakeBorder(inverse, around, 0, 0, 2 * side, 2 * side, cv::BORDER_WRAP);
  // An opening of the inverse distance removes what is near and narrower than its window.
  cv::Mat opened;
  cv::morphologyEx(around, opened, cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  const cv::Mat thin = around - opened > kNearer * around;
  cv::Mat mask;
  cv::dilate(thin, mask, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  return mask.colRange(2 * side, 2 * side + distance_m.cols).clone();
}

}  // namespace raywalk::capture
