#include "build_lf/depth/station_image.h"

#include <cstring>
#include <opencv2/imgproc.hpp>

namespace raywalk {

cv::Mat station_image(const Room& room, StationIndex station, PanoramaSize size) {
  const LineVolume& volume = room.volume(station.line);
  cv::Mat image(volume.panorama().width, volume.panorama().height, CV_8UC3);
  for (int theta = 0; theta < image.rows; ++theta) {
    const auto column = volume.column(station.station, theta);
    std::memcpy(image.ptr(theta), column.data(), column.size());
  }
  if (volume.panorama() == size) return image;
  cv::Mat reduced;
  cv::resize(image, reduced, {size.height, size.width}, 0, 0, cv::INTER_AREA);
  return reduced;
}

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
