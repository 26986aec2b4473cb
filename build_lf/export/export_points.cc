#include "build_lf/export/export_points.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <mutex>
#include <string>
#include <vector>

#include "build_lf/export/exported_stations.h"
#include "build_lf/export/station_surface.h"
#include "build_lf/export/voxel_points.h"
#include "build_lf/pack/room_maps.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/reconstruction/z_up_axes.h"

namespace raywalk::build_lf {
namespace {

static_assert(std::endian::native == std::endian::little, "the PLY is little-endian");

constexpr std::size_t kMostBytes = std::size_t{1} << 30;  // of all cubes
constexpr std::size_t kMostOfThread = 100'000;            // cubes before they join the others

// How often the maps are read, each time for a share of the cubes. In the worst case every pixel
// has a cube of its own.
int parts_of(const Room& room, const std::vector<MapStation>& maps) {
  double pixels = 0.0;
  for (const MapStation& map : maps) {
    const PanoramaSize size = room.distances(map.line).size();
    pixels += static_cast<double>(size.width) * size.height;
  }
  return std::max(1, static_cast<int>(std::ceil(pixels * VoxelPoints::kBytes / kMostBytes)));
}

// Adds the points of a map to `all`, which is locked.
class MapReader {
 public:
  MapReader(const Room& room, const ExportOptions& options, VoxelPoints* all)
      : room_(room), options_(options), all_(all) {}

  void read(const MapStation& map, VoxelPoints* own) {
    const StationSurface surface(room_, map.line, map.map, {options_.max_distance_m});
    const cv::Mat columns = station_columns(room_, map.line, surface.station(), options_.gains);
    for (int theta = 0; theta < surface.size().width; ++theta) {
      for (int row = 0; row < surface.size().height; ++row) {
        const auto point = surface.point_m(theta, row);
        if (!point) continue;
        own->add({*point, colour_at(columns, surface.direction(theta, row)),
                  surface.confidence(theta, row)});
      }
      if (own->size() > kMostOfThread) give(own);
    }
    give(own);
  }

 private:
  void give(VoxelPoints* own) {
    const std::lock_guard lock(mutex_);
    all_->take(own);
  }

  const Room& room_;
  const ExportOptions& options_;
  VoxelPoints* all_;
  std::mutex mutex_;
};

class PlyFile {
 public:
  explicit PlyFile(const std::filesystem::path& file)
      : file_(file), atomic_(file), stream_(atomic_.temporary_path(), std::ios::binary) {
    stream_ << header(0);
  }

  void write(const std::vector<CloudPoint>& points) {
    for (const CloudPoint& point : points) {
      const Eigen::Vector3f at = z_up_axes(point.position_m).cast<float>();
      std::array<char, 16> bytes{};
      std::memcpy(bytes.data(), at.data(), 12);
      for (std::size_t i = 0; i < 3; ++i) bytes[12 + i] = static_cast<char>(point.colour[i]);
      bytes[15] = static_cast<char>(point.confidence);
      stream_.write(bytes.data(), bytes.size());
    }
    count_ += static_cast<std::int64_t>(points.size());
    require_written();
  }

  std::int64_t count() const { return count_; }

  void complete() {
    stream_.seekp(0);
    stream_ << header(count_);
    stream_.close();
    require_written();
    atomic_.commit();
  }

 private:
  // Of the same length for any count: a comment is filled up.
  static std::string header(std::int64_t count) {
    const std::string number = std::to_string(count);
    return fmt::format(
        "ply\nformat binary_little_endian 1.0\n{}: metres, x right, y forward, z up{}\n"
        "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property uchar confidence\nend_header\n",
        kPointsSignature, std::string(20 - number.size(), ' '), number);
  }

  void require_written() const {
    if (stream_) return;
    throw Error(file_.string() + ": cannot be written (is the disk full?)");
  }

  std::filesystem::path file_;
  AtomicFile atomic_;
  std::ofstream stream_;
  std::int64_t count_ = 0;
};

}  // namespace

std::int64_t write_points(const Room& room, const ExportOptions& options,
                          const std::filesystem::path& file) {
  const std::vector<MapStation> maps = all_maps(room);
  if (maps.empty()) {
    throw Error(room.directory().string() +
                ": has no distances to make points of; estimate them with raywalk-build-lf depth");
  }
  const double side_m = options.voxel_mm / 1000.0;
  const int parts = parts_of(room, maps);
  PlyFile ply(file);
  Progress progress("Collecting points", static_cast<std::int64_t>(maps.size()) * parts, "maps");
  for (int part = 0; part < parts; ++part) {
    VoxelPoints voxels(side_m, parts, part);
    MapReader reader(room, options, &voxels);
    parallel_for(0, static_cast<int>(maps.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        VoxelPoints own(side_m, parts, part);
        reader.read(maps[static_cast<std::size_t>(i)], &own);
        progress.advance();
      }
    });
    ply.write(voxels.points());
  }
  if (ply.count() == 0) {
    throw Error(room.directory().string() +
                ": none of its distances is near enough and of sufficient confidence");
  }
  ply.complete();
  return ply.count();
}

}  // namespace raywalk::build_lf
