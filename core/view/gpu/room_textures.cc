#include "core/view/gpu/room_textures.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/room/gain_fields.h"
#include "core/room/tiled_rays.h"
#include "core/view/map_cache.h"
#include "core/view/mask_check.h"

namespace raywalk {
namespace {

// Of maps as many are kept as fit into so much memory, but at least as many as a view may want.
constexpr std::size_t kMapBytes = std::size_t{512} << 20, kLeastMaps = 128;
constexpr std::uint8_t kMoved = 128;

void mark_masked(const Room& room, ImageKey station, int theta, cv::Mat4b column) {
  const auto mark = [&](RowRun rows, std::uint8_t as) {
    for (int row = std::max(rows.begin, 0); row < std::min(rows.end, column.cols); ++row) {
      column(0, row)[3] = std::min(column(0, row)[3], as);
    }
  };
  const RowRun valid = room.volume(station.first).valid_rows(station.second, theta);
  mark({0, valid.begin}, 0);
  mark({valid.end, column.cols}, 0);
  const LeftOutPixels& moved = room.distances(station.first).left_out();
  if (!moved.any(station.second)) return;
  const PanoramaSize size = room.panorama(), maps = moved.size();
  const auto column_of_map = static_cast<int>(std::int64_t{theta} * maps.width / size.width);
  // Rows whose row * maps.height / size.height is in the run.
  const auto first_row = [&](int in_map) {
    return static_cast<int>((std::int64_t{in_map} * size.height + maps.height - 1) / maps.height);
  };
  for (const LeftOutRun& run : moved.rows(station.second, column_of_map)) {
    mark({first_row(run.begin), first_row(run.end)}, kMoved);
  }
}

}  // namespace

RoomTextures::RoomTextures(const Room& room, bool gains, std::uint64_t most_bytes)
    : room_(room), gains_(gains && !room.gains().empty()) {
  const PanoramaSize size = room.panorama();
  PanoramaSize maps{}, moved{};
  std::size_t stations = 0;
  bool masked = false;
  const auto lines = static_cast<int>(room.grid().lines.size());
  for (int line = 0; line < lines; ++line) {
    const int of_line = room.volume(line).stations();
    stations += static_cast<std::size_t>(of_line);
    const DistanceVolume& volume = room.distances(line);
    if (volume.size().width > maps.width) maps = volume.size();
    for (int station = 0; station < of_line; ++station) {
      if (!has_masks(room, line, station)) continue;
      masked = true;
      if (volume.left_out().size().width > moved.width) moved = volume.left_out().size();
    }
  }
  const auto pixels =
      static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
  stations_ = std::make_unique<LayeredTexture>(
      "panoramas", GL_RGBA8, size.height, size.width,
      static_cast<std::size_t>(std::min<std::uint64_t>(most_bytes / (4 * pixels), stations)));
  if (maps.width == 0) return;
  const auto layers = [&](int width, int height) {
    const std::size_t bytes =
        4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    return std::min(std::max(kMapBytes / bytes, kLeastMaps), stations);
  };
  maps_ = std::make_unique<LayeredTexture>("distance maps", GL_R32F, maps.height, maps.width,
                                           layers(maps.height, maps.width));
  if (!masked) return;
  mask_width_ = 1 + (moved.height + 31) / 32;
  mask_height_ = std::max(size.width, moved.width);
  masks_ = std::make_unique<LayeredTexture>("masks", GL_R32UI, mask_width_, mask_height_,
                                            layers(mask_width_, mask_height_));
}

void RoomTextures::bind() const {
  stations_->bind(kStations);
  if (maps_) maps_->bind(kMaps);
  if (masks_) masks_->bind(kMasks);
}

void RoomTextures::require_stations(std::span<const ImageKey> stations) {
  stations_->require(stations,
                     [&](ImageKey station, int layer) { upload_station(station, layer); });
}

void RoomTextures::require_maps(std::span<const ImageKey> maps) {
  maps_->require(maps, [&](ImageKey map, int layer) {
    const DistanceVolume& volume = room_.distances(map.first);
    const std::vector<float> inverse = inverse_distances(volume, map.second);
    glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, volume.size().height, volume.size().width,
                    1, GL_RED, GL_FLOAT, inverse.data());
  });
}

void RoomTextures::require_masks(std::span<const ImageKey> stations) {
  if (!masks_) return;
  std::vector<ImageKey> masked;
  std::ranges::copy_if(stations, std::back_inserter(masked), [&](const ImageKey& station) {
    return has_masks(room_, station.first, station.second);
  });
  masks_->require(masked, [&](ImageKey station, int layer) { upload_mask(station, layer); });
}

void RoomTextures::upload_mask(ImageKey station, int layer) {
  cv::Mat1i masks(mask_height_, mask_width_, 0);
  const LineVolume& volume = room_.volume(station.first);
  for (int theta = 0; theta < room_.panorama().width; ++theta) {
    const RowRun rows = volume.valid_rows(station.second, theta);
    masks(theta, 0) = rows.begin | rows.end << 16;
  }
  const LeftOutPixels& moved = room_.distances(station.first).left_out();
  for (int theta = 0; moved.any(station.second) && theta < moved.size().width; ++theta) {
    for (const LeftOutRun& run : moved.rows(station.second, theta)) {
      for (int row = run.begin; row < run.end; ++row) masks(theta, 1 + row / 32) |= 1 << row % 32;
    }
  }
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, mask_width_, mask_height_, 1, GL_RED_INTEGER,
                  GL_UNSIGNED_INT, masks.data);
}

void RoomTextures::upload_station(ImageKey station, int layer) {
  const PanoramaSize size = room_.panorama();
  const LineVolume& volume = room_.volume(station.first);
  volume.fetch(station.second, 0, volume.station_bytes());
  const TileReading reading;
  const auto rays = volume.columns(station.second);
  cv::Mat rgb(size.width, size.height, CV_8UC3, const_cast<std::uint8_t*>(rays.data()));
  if (gains_) {
    rgb = rgb.clone();
    apply_gains(room_.gains()[static_cast<std::size_t>(station.first)]
                             [static_cast<std::size_t>(station.second)],
                &rgb);
  }
  cv::Mat4b pixels(size.width, size.height);
  const bool masks = has_masks(room_, station.first, station.second);
  parallel_for(0, size.width, 64, [&](int begin, int end) {
    cv::Mat4b part = pixels.rowRange(begin, end);
    cv::cvtColor(rgb.rowRange(begin, end), part, cv::COLOR_RGB2RGBA);
    for (int theta = begin; masks && theta < end; ++theta) {
      mark_masked(room_, station, theta, pixels.row(theta));
    }
  });
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, size.height, size.width, 1, GL_RGBA,
                  GL_UNSIGNED_BYTE, pixels.data);
}

}  // namespace raywalk
