#include "build_lf/pack/station_data.h"

#include <fmt/format.h>

#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <span>

#include "core/base/error.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/panorama/panorama_rotation.h"
#include "core/panorama/picture_look.h"
#include "core/room/line_volume.h"

namespace raywalk::build_lf {
namespace {

// Reads an image and checks its size again, as the file may have changed since its header was read.
template <typename Read>
cv::Mat read_checked(const std::filesystem::path& file, PanoramaSize size, const Read& read) {
  cv::Mat image = read(file);
  if (image.cols != size.width || image.rows != size.height) {
    throw Error(fmt::format("{}: the image size changed during packing", file.string()));
  }
  return image;
}

// The mask in world axes, like the packed panorama.
cv::Mat read_station_mask(const StationSource& source, PanoramaSize size) {
  cv::Mat mask;
  try {
    mask = read_mask(*source.mask, size);
  } catch (const Error& error) {
    throw Error(source.where + ": " + error.what());
  }
  return source.attitude ? rotate_mask(mask, world_from_camera(*source.attitude)) : mask;
}

}  // namespace

std::string checksum_of_distances(std::span<const float> distance_m,
                                  std::span<const std::uint8_t> confidence) {
  const std::string both =
      sha256_hex(std::as_bytes(distance_m)) + sha256_hex(std::as_bytes(confidence));
  return sha256_hex(both);
}

std::string checksum_of_rays(std::span<const std::uint8_t> rays,
                             std::span<const std::int32_t> valid_rows) {
  std::string of_rays = sha256_hex(std::as_bytes(rays));
  if (valid_rows.empty()) return of_rays;
  const std::string both = of_rays + sha256_hex(std::as_bytes(valid_rows));
  return sha256_hex(both);
}

std::vector<std::int32_t> valid_rows_of(const cv::Mat& mask) {
  std::vector<std::int32_t> valid_rows;
  for (int u = 0; u < mask.cols; ++u) {
    RowRun longest;
    for (int row = 0; row < mask.rows;) {
      RowRun run{row, row};
      while (run.end < mask.rows && mask.at<uchar>(run.end, u) != 0) ++run.end;
      if (run.end - run.begin > longest.end - longest.begin) longest = run;
      row = run.end + 1;
    }
    valid_rows.insert(valid_rows.end(), {longest.begin, longest.end});
  }
  return valid_rows;
}

StationRays stored_rays(const LineVolume& volume, int station) {
  const TileReading reading;
  const auto columns = volume.columns(station);
  const auto valid_rows = volume.stored_valid_rows(station);
  return {{columns.begin(), columns.end()}, {valid_rows.begin(), valid_rows.end()}};
}

StationDistances stored_distances(const DistanceVolume& volume, int map) {
  // The columns of a map are contiguous in memory.
  const auto all = [&](auto first_column) {
    return std::vector(
        first_column.data(),
        first_column.data() + first_column.size() * static_cast<std::size_t>(volume.size().width));
  };
  StationDistances distances{
      all(volume.distance_column(map, 0)), all(volume.confidence_column(map, 0)), {}};
  distances.sha256 = checksum_of_distances(distances.distance_m, distances.confidence);
  return distances;
}

StationRays read_station_rays(const StationSource& source, PanoramaSize size) {
  cv::Mat panorama = read_checked(source.panorama, size, read_panorama);
  if (look_at_picture(panorama) == PictureKind::kDualFisheye) {
    throw Error(fmt::format(
        "{}: shows the circles of two fisheye lenses, not a panorama; let raywalk-calibrate stitch "
        "it",
        source.panorama.string()));
  }
  if (source.attitude) panorama = rotate_panorama(panorama, world_from_camera(*source.attitude));
  StationRays station;
  station.rays.resize(panorama.total() * panorama.elemSize());
  // Rows of the transposed image are columns of the panorama: [theta][phi].
  cv::Mat rays(panorama.cols, panorama.rows, CV_8UC3, station.rays.data());
  cv::transpose(panorama, rays);
  cv::cvtColor(rays, rays, cv::COLOR_BGR2RGB);
  if (source.mask) station.valid_rows = valid_rows_of(read_station_mask(source, size));
  return station;
}

StationDistances read_station_distances(const StationSource& source, PanoramaSize size) {
  cv::Mat map = read_checked(*source.distance_map, size, read_distance_map);
  if (source.attitude) map = rotate_distance_map(map, world_from_camera(*source.attitude));
  cv::Mat columns;
  cv::transpose(map, columns);
  StationDistances station;
  station.confidence.assign(columns.total(), 255);
  station.distance_m.reserve(columns.total());
  for (auto mm = columns.begin<ushort>(); mm != columns.end<ushort>(); ++mm) {
    station.distance_m.push_back(*mm == 0 ? std::numeric_limits<float>::infinity()
                                          : static_cast<float>(*mm) * 1e-3F);
  }
  station.sha256 = checksum_of_distances(station.distance_m, station.confidence);
  return station;
}

}  // namespace raywalk::build_lf
