#include "build_lf/export/export_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "build_lf/export/exported_stations.h"
#include "build_lf/export/point_cloud.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/reconstruction/nerfstudio_file.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr int kFarthest_mm = 65535;

// 16 bits end at 65.5 m. What is farther is stored as that or as no surface, whichever is closer in
// inverse distance, to which parallax is proportional.
std::uint16_t millimetres(float distance_m) {
  if (!std::isfinite(distance_m) || distance_m <= 0.0F) return 0;
  const double millimetres = 1000.0 * static_cast<double>(distance_m);
  if (millimetres > 2.0 * kFarthest_mm) return 0;
  return static_cast<std::uint16_t>(std::clamp(std::lround(millimetres), 1L, long{kFarthest_mm}));
}

struct MapPictures {
  cv::Mat distance{};    // CV_16UC1
  cv::Mat confidence{};  // CV_8UC1
};

MapPictures pictures_of(const DistanceVolume& volume, int map) {
  const cv::Size size(volume.size().width, volume.size().height);
  MapPictures pictures{cv::Mat(size, CV_16UC1), cv::Mat(size, CV_8UC1)};
  for (int theta = 0; theta < size.width; ++theta) {
    const auto distances = volume.distance_column(map, theta);
    const auto confidences = volume.confidence_column(map, theta);
    for (int row = 0; row < size.height; ++row) {
      const auto i = static_cast<std::size_t>(row);
      pictures.distance.at<std::uint16_t>(row, theta) =
          confidences[i] == 0 ? std::uint16_t{0} : millimetres(distances[i]);
      pictures.confidence.at<std::uint8_t>(row, theta) = confidences[i];
    }
  }
  return pictures;
}

// Returns the number of maps.
int write_maps(const Room& room, const std::vector<ExportedStation>& stations,
               const fs::path& directory) {
  if (!room.has_distances()) return 0;
  make_directories(directory / "distances");
  make_directories(directory / "confidence");
  std::atomic<int> maps = 0;
  Progress progress("Writing distances", static_cast<std::int64_t>(stations.size()), "stations");
  parallel_for(0, static_cast<int>(stations.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const ExportedStation& station = stations[static_cast<std::size_t>(i)];
      const DistanceVolume& volume = room.distances(station.index.line);
      if (const auto map = volume.map_of(station.index.station)) {
        const MapPictures pictures = pictures_of(volume, *map);
        write_image(directory / "distances" / (station.name + ".png"), pictures.distance);
        write_image(directory / "confidence" / (station.name + ".png"), pictures.confidence);
        ++maps;
      }
      progress.advance();
    }
  });
  return maps;
}

// Relative to the export, with '/'.
std::string mask_file(const ExportedStation& station) { return "masks/" + station.file(false); }

// Masks only where the room has pixels that are not to be used, then of all stations. Returns
// whether there are any.
bool write_panoramas(const Room& room, const std::vector<ExportedStation>& stations,
                     const ExportOptions& options, const fs::path& directory) {
  const bool masked = has_unusable_pixels(room);
  make_directories(directory / "images");
  if (masked) make_directories(directory / "masks");
  Progress progress("Writing panoramas", std::ssize(stations), "panoramas");
  parallel_for(0, static_cast<int>(stations.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const ExportedStation& station = stations[static_cast<std::size_t>(i)];
      write_image(directory / "images" / station.file(options.jpeg),
                  station_picture(room, station.index, options.gains));
      if (masked) write_image(directory / mask_file(station), station_mask(room, station.index));
      progress.advance();
    }
  });
  return masked;
}

}  // namespace

std::string write_nerfstudio(const Room& room, const std::vector<ExportedStation>& stations,
                             const ExportOptions& options, const fs::path& directory) {
  const bool masked = write_panoramas(room, stations, options, directory);
  std::vector<NerfstudioFrame> frames;
  frames.reserve(stations.size());
  for (const ExportedStation& station : stations) {
    frames.push_back({.file = "images/" + station.file(options.jpeg),
                      .mask = masked ? mask_file(station) : "",
                      .pose = station.pose()});
  }
  std::string points;
  std::int64_t count = 0;
  if (room.has_distances()) {
    points = "points.ply";
    count = write_points(room, options, directory / points);
  }
  write_file_atomically(directory / "transforms.json",
                        nerfstudio_text(frames, room.panorama(), points));
  return fmt::format("{} panoramas, {} points", frames.size(), count);
}

std::string write_frames(const Room& room, const std::vector<ExportedStation>& stations,
                         const ExportOptions& options, const fs::path& directory) {
  const bool masked = write_panoramas(room, stations, options, directory);
  std::vector<ListedFrame> rows;
  rows.reserve(stations.size());
  for (const ExportedStation& station : stations) {
    rows.push_back({.file = "images/" + station.file(options.jpeg),
                    .position_m = station.position_m,
                    .mask = masked ? mask_file(station) : "",
                    .line = room.grid().line_of(station.index).id});
  }
  const int maps = write_maps(room, stations, directory);
  write_file_atomically(directory / "poses.csv", frame_list_text(rows));
  return fmt::format("{} panoramas, {} distance maps", rows.size(), maps);
}

}  // namespace raywalk::build_lf
