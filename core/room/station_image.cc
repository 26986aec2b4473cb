#include "core/room/station_image.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/panorama/transposed_border.h"
#include "core/room/tiled_rays.h"

namespace raywalk {

cv::Mat captured_columns(const LineVolume& volume, int station) {
  cv::Mat columns(volume.panorama().width, volume.panorama().height, CV_8UC3);
  for (int theta = 0; theta < columns.rows; ++theta) {
    const TileReading reading;
    std::ranges::copy(volume.column(station, theta), columns.ptr(theta));
  }
  return columns;
}

cv::Mat captured_validity(const LineVolume& volume, int station) {
  if (!volume.masked()) return {};
  cv::Mat valid(volume.panorama().width, volume.panorama().height, CV_8UC1, cv::Scalar(0));
  for (int theta = 0; theta < valid.rows; ++theta) {
    const RowRun rows = volume.valid_rows(station, theta);
    if (!rows.empty()) valid.row(theta).colRange(rows.begin, rows.end).setTo(255);
  }
  return valid;
}

cv::Mat station_image(const Room& room, StationIndex station, PanoramaSize size) {
  cv::Mat image = captured_columns(room.volume(station.line), station.station);
  if (room.panorama() == size) return image;
  cv::Mat reduced;
  cv::resize(image, reduced, {size.height, size.width}, 0, 0, cv::INTER_AREA);
  return reduced;
}

cv::Mat station_validity(const Room& room, StationIndex station, PanoramaSize size, int margin_px) {
  cv::Mat valid = captured_validity(room.volume(station.line), station.station);
  if (valid.empty()) return {};
  if (room.panorama() != size) {
    cv::Mat share;
    cv::resize(valid, share, {size.height, size.width}, 0, 0, cv::INTER_AREA);
    valid = share == 255;
  }
  const int around = 2 * margin_px + 1;
  cv::Mat clear;
  cv::erode(with_border(valid, margin_px), clear, cv::Mat::ones(around, around, CV_8UC1));
  return without_border(clear, margin_px).clone();
}

}  // namespace raywalk
