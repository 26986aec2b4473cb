#include "core/panorama/gain_field.h"

#include <opencv2/imgproc.hpp>

#include "core/panorama/transposed_border.h"

namespace raywalk {

void apply_gains(const GainField& gains, cv::Mat* colours) {
  const ColourGain& whole = gains.whole;
  const cv::Scalar factors(whole[0], whole[1], whole[2]);
  if (gains.local.empty()) {
    cv::multiply(*colours, factors, *colours);
    return;
  }
  // With a border of one patch, interpolation crosses the seam and the poles.
  const cv::Mat bordered = with_border(gains.local, 1);
  const double patches_phi = static_cast<double>(gains.local.cols) / colours->cols;
  const double patches_theta = static_cast<double>(gains.local.rows) / colours->rows;
  // From the middle of a pixel to that of a patch, which is 1 more because of the border.
  const cv::Matx23d patch_from_pixel(patches_phi, 0.0, 0.5 * patches_phi + 0.5,  //
                                     0.0, patches_theta, 0.5 * patches_theta + 0.5);
  cv::Mat field;
  cv::warpAffine(bordered, field, patch_from_pixel, colours->size(),
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  cv::Mat levels;
  colours->convertTo(levels, CV_32F);
  cv::multiply(levels, field, levels);
  cv::multiply(levels, factors, levels);
  levels.convertTo(*colours, CV_8U);
}

}  // namespace raywalk
