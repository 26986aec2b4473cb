#include "build_lf/export/exported_stations.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/files/frame_list.h"
#include "core/geometry/panorama_pixels.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

void leave_out(const LeftOutPixels& left_out, int station, cv::Mat* mask) {
  if (!left_out.any(station)) return;
  const PanoramaSize size = left_out.size();
  const double rows = static_cast<double>(mask->rows) / size.height;
  for (int u = 0; u < mask->cols; ++u) {
    const int theta = u * size.width / mask->cols;
    for (const RowRun& run : left_out.rows(station, theta)) {
      const int begin = static_cast<int>(run.begin * rows);
      const int end = std::min(mask->rows, static_cast<int>(std::ceil(run.end * rows)));
      mask->col(u).rowRange(begin, end).setTo(0);
    }
  }
}

}  // namespace

std::vector<ExportedStation> exported_stations(const Room& room, int every) {
  std::vector<ExportedStation> stations;
  std::vector<std::string> files;
  for (const StationIndex index : all_stations(room.grid())) {
    if (index.station % every != 0) continue;
    const Station& station = room.grid().station(index);
    stations.push_back({.index = index, .position_m = station.position_m});
    files.push_back(station.file);
  }
  const std::vector<std::string> names = frame_names(files, room.directory());
  for (std::size_t i = 0; i < stations.size(); ++i) stations[i].name = names[i];
  return stations;
}

cv::Mat station_columns(const Room& room, StationIndex station, bool gains) {
  cv::Mat columns = captured_columns(room.volume(station.line), station.station);
  if (gains && !room.gains().empty()) {
    const std::vector<GainField>& fields = room.gains()[static_cast<std::size_t>(station.line)];
    apply_gains(fields[static_cast<std::size_t>(station.station)], &columns);
  }
  return columns;
}

cv::Mat station_picture(const Room& room, StationIndex station, bool gains) {
  cv::Mat picture;
  cv::cvtColor(station_columns(room, station, gains).t(), picture, cv::COLOR_RGB2BGR);
  return picture;
}

std::array<std::uint8_t, 3> colour_at(const cv::Mat& columns, const Eigen::Vector3d& direction) {
  const PanoramaSize size{columns.rows, columns.cols};  // transposed
  const PixelsAround pixels =
      pixels_around(pixel_from_angles(angles_from_direction(direction), size), size);
  const cv::Vec3b colour = columns.at<cv::Vec3b>(pixels.nearest_column(), pixels.nearest_row());
  return {colour[0], colour[1], colour[2]};
}

bool has_unusable_pixels(const Room& room) {
  return room.masked() || std::ranges::any_of(all_stations(room.grid()), [&](StationIndex at) {
           return room.distances(at.line).left_out().any(at.station);
         });
}

cv::Mat station_mask(const Room& room, StationIndex station) {
  const LineVolume& volume = room.volume(station.line);
  const auto [width, height] = volume.panorama();
  cv::Mat mask = volume.masked() ? cv::Mat(captured_validity(volume, station.station).t())
                                 : cv::Mat(height, width, CV_8UC1, cv::Scalar(255));
  leave_out(room.distances(station.line).left_out(), station.station, &mask);
  return mask;
}

}  // namespace raywalk::build_lf
