#include "build_lf/refine/fine_map.h"

#include <opencv2/imgproc.hpp>

#include "core/panorama/transposed_border.h"

namespace raywalk::build_lf {

OmegaMap enlarged(const OmegaMap& map, int width) {
  OmegaMap fine = resized(map, width);
  const int factor = width / map.size().width;
  if (factor < 2) return fine;
  // Of n x n pixels a line of `factor` pixels is more than half for n = 2 factor - 1; of floats
  // OpenCV has medians of up to 5 x 5.
  const int window = factor == 2 ? 3 : 5;
  constexpr int kBorder = 2;
  const PanoramaSize size = fine.size();
  cv::Mat omega(size.width, size.height, CV_32F, fine.values().data());
  cv::Mat smooth = with_border(omega, kBorder);
  cv::medianBlur(smooth, smooth, window);
  without_border(smooth, kBorder).copyTo(omega);
  return fine;
}

}  // namespace raywalk::build_lf
