#include "build_lf/depth/contradicted_regions.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/panorama/transposed_border.h"

namespace raywalk::build_lf {
namespace {

constexpr int kBorder_px = 12;  // so that regions across the seam and the poles are whole
constexpr int kMinStrongPixels = 16;
constexpr double kMinCore_px = 2.5;  // distance of the innermost pixel from the outside
constexpr int kMixed_px = 2;         // colours are compared within a pixel, and pixels are mixed

cv::Mat square_around(int around_px) {
  return cv::Mat::ones(2 * around_px + 1, 2 * around_px + 1, CV_8UC1);
}

}  // namespace

cv::Mat contradicted_regions(const cv::Mat& gaps, GapLimits limits) {
  const cv::Mat bordered = with_border(gaps, kBorder_px);
  cv::Mat weak = bordered > limits.weak;
  // Parts whose colour happens to be that of the room.
  cv::morphologyEx(weak, weak, cv::MORPH_CLOSE, square_around(1));
  cv::Mat inside;
  cv::distanceTransform(weak, inside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat labels;
  const int count = cv::connectedComponents(weak, labels, 4, CV_32S);
  std::vector<int> strong(static_cast<size_t>(count));
  std::vector<float> core(static_cast<size_t>(count));
  for (int row = 0; row < labels.rows; ++row) {
    for (int column = 0; column < labels.cols; ++column) {
      const auto label = static_cast<size_t>(labels.at<int>(row, column));
      strong[label] += bordered.at<float>(row, column) > limits.strong ? 1 : 0;
      core[label] = std::max(core[label], inside.at<float>(row, column));
    }
  }
  cv::Mat regions = cv::Mat::zeros(labels.size(), CV_8UC1);
  for (int row = 0; row < labels.rows; ++row) {
    for (int column = 0; column < labels.cols; ++column) {
      const auto label = static_cast<size_t>(labels.at<int>(row, column));
      const bool kept =
          label > 0 && strong[label] >= kMinStrongPixels && core[label] >= kMinCore_px;
      regions.at<uchar>(row, column) = kept ? 255 : 0;
    }
  }
  cv::dilate(regions, regions, square_around(kMixed_px));
  return without_border(regions, kBorder_px).clone();
}

}  // namespace raywalk::build_lf
