#include "build_lf/depth/station_image.h"

#include <cstring>
#include <opencv2/imgproc.hpp>

#include "core/panorama/transposed_border.h"
#include "core/room/tiled_rays.h"

namespace raywalk::build_lf {

cv::Mat station_image(const Room& room, StationIndex station, PanoramaSize size) {
  const LineVolume& volume = room.volume(station.line);
  cv::Mat image(volume.panorama().width, volume.panorama().height, CV_8UC3);
  for (int theta = 0; theta < image.rows; ++theta) {
    const TileReading reading;
    const auto column = volume.column(station.station, theta);
    std::memcpy(image.ptr(theta), column.data(), column.size());
  }
  if (volume.panorama() == size) return image;
  cv::Mat reduced;
  cv::resize(image, reduced, {size.height, size.width}, 0, 0, cv::INTER_AREA);
  return reduced;
}

cv::Mat station_validity(const Room& room, StationIndex station, PanoramaSize size, int margin_px) {
  const LineVolume& volume = room.volume(station.line);
  if (!volume.masked()) return {};
  cv::Mat valid(volume.panorama().width, volume.panorama().height, CV_8UC1, cv::Scalar(0));
  for (int theta = 0; theta < valid.rows; ++theta) {
    const RowRun rows = volume.valid_rows(station.station, theta);
    if (!rows.empty()) valid.row(theta).colRange(rows.begin, rows.end).setTo(255);
  }
  if (volume.panorama() != size) {
    cv::Mat share;
    cv::resize(valid, share, {size.height, size.width}, 0, 0, cv::INTER_AREA);
    valid = share == 255;
  }
  const int around = 2 * margin_px + 1;
  cv::Mat clear;
  cv::erode(with_border(valid, margin_px), clear, cv::Mat::ones(around, around, CV_8UC1));
  return without_border(clear, margin_px).clone();
}

}  // namespace raywalk::build_lf
