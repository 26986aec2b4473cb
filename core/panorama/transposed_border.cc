#include "core/panorama/transposed_border.h"

#include <opencv2/core.hpp>

namespace raywalk {

cv::Mat with_border(const cv::Mat& image, int border_px) {
  cv::Mat wrapped;
  cv::Mat bordered;
  cv::copyMakeBorder(image, wrapped, border_px, border_px, 0, 0, cv::BORDER_WRAP);
  cv::copyMakeBorder(wrapped, bordered, 0, 0, border_px, border_px, cv::BORDER_REFLECT);
  return bordered;
}

cv::Mat without_border(const cv::Mat& bordered, int border_px) {
  return bordered(
      cv::Rect(border_px, border_px, bordered.cols - 2 * border_px, bordered.rows - 2 * border_px));
}

}  // namespace raywalk
