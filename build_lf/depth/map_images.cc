#include "build_lf/depth/map_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

// [theta][phi] values as an upright image.
template <typename T>
cv::Mat upright(const std::vector<T>& values, PanoramaSize size, int type) {
  const cv::Mat columns(size.width, size.height, type, const_cast<T*>(values.data()));
  return columns.t();
}

cv::Mat panorama_image(const Room& room, const InverseDistanceMap& map) {
  cv::Mat image;
  cv::cvtColor(station_image(room, map.station, map.size).t(), image, cv::COLOR_RGB2BGR);
  return image;
}

cv::Mat distance_image(const InverseDistanceMap& map) {
  std::vector<float> sorted = map.inverse;
  const auto near = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 999 / 1000);
  std::nth_element(sorted.begin(), near, sorted.end());
  cv::Mat levels;
  upright(map.inverse, map.size, CV_32FC1).convertTo(levels, CV_8U, 255.0 / std::max(1e-9f, *near));
  cv::Mat image;
  cv::applyColorMap(levels, image, cv::COLORMAP_TURBO);
  return image;
}

// Grey for confident pixels, red below kMinConfidence.
cv::Mat confidence_image(const InverseDistanceMap& map) {
  const cv::Mat confidence = upright(map.confidence, map.size, CV_8UC1);
  cv::Mat image;
  cv::cvtColor(confidence, image, cv::COLOR_GRAY2BGR);
  image.setTo(cv::Scalar(40, 40, 220), confidence < kMinConfidence);
  return image;
}

}  // namespace

std::vector<ReportImage> map_images(const Room& room, const std::vector<InverseDistanceMap>& maps) {
  std::vector<ReportImage> images;
  for (const InverseDistanceMap& map : maps) {
    const std::string where = fmt::format(
        "line {}, station {}", room.grid().lines[static_cast<size_t>(map.station.line)].id,
        map.station.station);
    images.push_back(report_image("maps", where, "panorama", panorama_image(room, map)));
    images.push_back(report_image("maps", where, "inverse distance", distance_image(map)));
    images.push_back(report_image("maps", where, "confidence", confidence_image(map)));
  }
  return images;
}

}  // namespace raywalk::build_lf
