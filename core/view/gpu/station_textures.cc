#include "core/view/gpu/station_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/room/gain_fields.h"
#include "core/room/tiled_rays.h"
#include "core/view/gpu/gpu_context.h"
#include "core/view/mask_check.h"

namespace raywalk {
namespace {

constexpr StationKey kNone{-1, -1};
constexpr std::uint8_t kMoved = 128;

void mark_masked(const Room& room, StationKey station, int theta, cv::Mat4b column) {
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

StationTextures::StationTextures(const Room& room, bool gains, std::uint64_t most_bytes)
    : room_(room), gains_(gains && !room.gains().empty()) {
  const PanoramaSize size = room.panorama();
  GLint most_layers = 0, most_pixels = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most_pixels);
  std::size_t stations = 0;
  for (const Line& line : room.grid().lines) stations += line.stations.size();
  const std::uint64_t bytes = 4 * std::uint64_t(size.width) * std::uint64_t(size.height);
  const auto layers = static_cast<std::size_t>(
      std::min<std::uint64_t>({most_bytes / bytes, std::uint64_t(most_layers), stations}));
  if (size.width > most_pixels || layers == 0) {
    throw GpuError(
        fmt::format("panoramas of {} x {} pixels are too large for the card or for "
                    "--gpu-mb",
                    size.width, size.height));
  }
  glGenTextures(1, &texture_);
  bind(0);
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, 1, GL_RGBA8, size.height, size.width,
                 static_cast<GLsizei>(layers));
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  try {
    check_gpu("the stations' panoramas; give less by --gpu-mb");
  } catch (const GpuError&) {
    glDeleteTextures(1, &texture_);
    throw;
  }
  keys_.assign(layers, kNone);
  wanted_.assign(layers, 0);
}

StationTextures::~StationTextures() { glDeleteTextures(1, &texture_); }

void StationTextures::bind(GLuint unit) const {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture_);
}

void StationTextures::require(std::span<const StationKey> stations) {
  ++turn_;
  std::vector<StationKey> missing;
  for (const StationKey& station : stations) {
    const auto found = at_.find(station);
    if (found == at_.end()) {
      missing.push_back(station);
    } else {
      wanted_[static_cast<std::size_t>(found->second)] = turn_;
    }
  }
  for (const StationKey& station : missing) {
    const auto oldest = std::ranges::min_element(wanted_) - wanted_.begin();
    const auto layer = static_cast<std::size_t>(oldest);
    at_.erase(keys_[layer]);
    keys_[layer] = kNone;
    upload(station, static_cast<int>(layer));
    keys_[layer] = station;
    wanted_[layer] = turn_;
    at_[station] = static_cast<int>(layer);
  }
}

void StationTextures::upload(StationKey station, int layer) {
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
  bind(0);
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, size.height, size.width, 1, GL_RGBA,
                  GL_UNSIGNED_BYTE, pixels.data);
  check_gpu("a station's panorama");
}

}  // namespace raywalk
