#include "core/evaluate/captured_station.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/room/tiled_rays.h"

namespace raywalk {

cv::Mat captured_columns(const LineVolume& volume, int station, const SampledPixels& pixels) {
  cv::Mat sampled(pixels.columns(), pixels.rows(), CV_8UC3);
  for (int i = 0; i < sampled.rows; ++i) {
    const TileReading reading;
    const auto column = volume.column(station, pixels.at(i));
    auto* const out = sampled.ptr<std::uint8_t>(i);
    if (pixels.stride == 1) {
      std::ranges::copy(column, out);
      continue;
    }
    for (int j = 0; j < sampled.cols; ++j) {
      std::copy_n(column.data() + 3 * pixels.at(j), 3, out + 3 * j);
    }
  }
  return sampled;
}

cv::Mat valid_columns(const LineVolume& volume, int station, const SampledPixels& pixels) {
  cv::Mat valid(pixels.columns(), pixels.rows(), CV_8UC1, cv::Scalar(0));
  for (int i = 0; i < valid.rows; ++i) {
    const RowRun rows = volume.valid_rows(station, pixels.at(i));
    for (int j = 0; j < valid.cols; ++j) {
      if (pixels.at(j) >= rows.begin && pixels.at(j) < rows.end) valid.at<std::uint8_t>(i, j) = 255;
    }
  }
  return valid;
}

cv::Mat captured_picture(const LineVolume& volume, int station) {
  cv::Mat picture;
  cv::cvtColor(captured_columns(volume, station, {volume.panorama()}).t(), picture,
               cv::COLOR_RGB2BGR);
  return picture;
}

cv::Mat captured_mask(const LineVolume& volume, int station) {
  if (!volume.masked()) return {};
  return valid_columns(volume, station, {volume.panorama()}).t();
}

}  // namespace raywalk
