#include "build_lf/export/exported_stations.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
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
  for (std::size_t line = 0; line < room.grid().lines.size(); ++line) {
    const std::vector<Station>& of_line = room.grid().lines[line].stations;
    for (std::size_t i = 0; i < of_line.size(); i += static_cast<std::size_t>(every)) {
      stations.push_back({.line = static_cast<int>(line),
                          .station = static_cast<int>(i),
                          .position_m = of_line[i].position_m});
      files.push_back(of_line[i].file);
    }
  }
  const std::vector<std::string> names = frame_names(files, room.directory());
  for (std::size_t i = 0; i < stations.size(); ++i) stations[i].name = names[i];
  return stations;
}

cv::Mat station_columns(const Room& room, int line, int station, bool gains) {
  const LineVolume& volume = room.volume(line);
  cv::Mat columns = captured_columns(volume, station);
  if (gains && !room.gains().empty()) {
    const std::vector<GainField>& fields = room.gains()[static_cast<std::size_t>(line)];
    apply_gains(fields[static_cast<std::size_t>(station)], &columns);
  }
  return columns;
}

cv::Mat station_picture(const Room& room, const ExportedStation& station, bool gains) {
  cv::Mat picture;
  cv::cvtColor(station_columns(room, station.line, station.station, gains).t(), picture,
               cv::COLOR_RGB2BGR);
  return picture;
}

bool has_unusable_pixels(const Room& room) {
  if (room.masked()) return true;
  for (std::size_t line = 0; line < room.grid().lines.size(); ++line) {
    const LeftOutPixels& left_out = room.distances(static_cast<int>(line)).left_out();
    for (int i = 0; i < room.volume(static_cast<int>(line)).stations(); ++i) {
      if (left_out.any(i)) return true;
    }
  }
  return false;
}

cv::Mat station_mask(const Room& room, const ExportedStation& station) {
  const LineVolume& volume = room.volume(station.line);
  cv::Mat mask(volume.panorama().height, volume.panorama().width, CV_8UC1, cv::Scalar(255));
  if (volume.masked()) mask = captured_validity(volume, station.station).t();
  leave_out(room.distances(station.line).left_out(), station.station, &mask);
  return mask;
}

std::string picture_name(const ExportedStation& station, bool jpeg) {
  return station.name + (jpeg ? ".jpg" : ".png");
}

std::string panorama_file(const ExportedStation& station, bool jpeg) {
  return "images/" + picture_name(station, jpeg);
}

std::string mask_file(const ExportedStation& station) { return "masks/" + station.name + ".png"; }

void write_panoramas(const Room& room, const std::vector<ExportedStation>& stations,
                     const ExportOptions& options, const std::filesystem::path& directory) {
  const bool masked = has_unusable_pixels(room);
  make_directories(directory / "images");
  if (masked) make_directories(directory / "masks");
  Progress progress("Writing panoramas", static_cast<std::int64_t>(stations.size()), "panoramas");
  parallel_for(0, static_cast<int>(stations.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const ExportedStation& station = stations[static_cast<std::size_t>(i)];
      write_image(directory / panorama_file(station, options.jpeg),
                  station_picture(room, station, options.gains));
      if (masked) write_image(directory / mask_file(station), station_mask(room, station));
      progress.advance();
    }
  });
}

}  // namespace raywalk::build_lf
