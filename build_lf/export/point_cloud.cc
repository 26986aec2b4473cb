#include "build_lf/export/point_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <mutex>
#include <string>

#include "build_lf/export/exported_stations.h"
#include "build_lf/export/station_surface.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/reconstruction/z_up_axes.h"
#include "core/view/map_choice.h"

namespace raywalk::build_lf {
namespace {

static_assert(std::endian::native == std::endian::little, "the PLY is little-endian");

// Cubes are counted from the origin, each axis in some bits of a key.
constexpr int kAxisBits = 21;
constexpr std::int64_t kHalfAxis = std::int64_t{1} << (kAxisBits - 1);
constexpr std::uint64_t kAxisMask = (std::uint64_t{1} << kAxisBits) - 1;
constexpr double kPlaceSteps = 65536.0;

// The corner of a cube, in cubes from the origin.
Eigen::Vector3d corner_of(std::uint64_t key) {
  const auto axis = [&](int shift) {
    return static_cast<double>(static_cast<std::int64_t>((key >> shift) & kAxisMask) - kHalfAxis);
  };
  return {axis(0), axis(2 * kAxisBits), axis(kAxisBits)};
}

// Adds what a map shows to `all`, from time to time, which is when `mutex` is locked.
void collect_points(const Room& room, const MapStation& map, const ExportOptions& options,
                    VoxelPoints own, std::mutex* mutex, VoxelPoints* all) {
  constexpr std::size_t kMostOwn = 100'000;
  const auto give = [&] {
    const std::lock_guard lock(*mutex);
    all->take(&own);
  };
  const StationIndex station{map.line, map.station};
  const StationSurface surface(room, station, map.map, options.max_distance_m);
  const cv::Mat columns = station_columns(room, station, options.gains);
  for (int theta = 0; theta < surface.size().width; ++theta) {
    for (int row = 0; row < surface.size().height; ++row) {
      const auto point = surface.point_m(theta, row);
      if (!point) continue;
      own.add({*point, colour_at(columns, surface.direction(theta, row)),
               surface.confidence(theta, row)});
    }
    if (own.size() > kMostOwn) give();
  }
  give();
}

void write_ply(const std::filesystem::path& file, const std::vector<CloudPoint>& points) {
  AtomicFile atomic(file);
  std::ofstream stream(atomic.temporary_path(), std::ios::binary);
  stream << fmt::format(
      "ply\nformat binary_little_endian 1.0\n{}: metres, x right, y forward, z up\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property uchar confidence\nend_header\n",
      kPointsSignature, points.size());
  for (const CloudPoint& point : points) {
    const Eigen::Vector3f at = z_up_axes(point.position_m).cast<float>();
    std::array<char, 16> bytes{};
    std::memcpy(bytes.data(), at.data(), 12);
    std::memcpy(bytes.data() + 12, point.colour.data(), 3);
    bytes[15] = static_cast<char>(point.confidence);
    stream.write(bytes.data(), bytes.size());
  }
  stream.close();
  if (!stream) throw Error(file.string() + ": cannot be written (is the disk full?)");
  atomic.commit();
}

}  // namespace

// The finaliser of SplitMix64 (Steele et al. 2014), which spreads neighbouring keys.
std::size_t VoxelPoints::Hash::operator()(std::uint64_t key) const {
  key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9ULL;
  key = (key ^ (key >> 27)) * 0x94d049bb133111ebULL;
  return key ^ (key >> 31);
}

void VoxelPoints::Voxel::add(std::uint64_t times, const Voxel& other) {
  weight += times * other.weight;
  for (std::size_t i = 0; i < 3; ++i) {
    place[i] += times * other.place[i];
    colour[i] += times * other.colour[i];
  }
  confidence = std::max(confidence, other.confidence);
}

void VoxelPoints::add(const CloudPoint& point) {
  std::uint64_t key = 0;
  Voxel one{.weight = 1, .confidence = point.confidence};
  std::ranges::copy(point.colour, one.colour.begin());
  for (const int axis : {1, 2, 0}) {
    const double cubes = point.position_m[axis] / side_m_;
    const double cube = std::floor(cubes);
    if (!(std::abs(cube) < kHalfAxis)) {
      throw Error(
          fmt::format("a point is {:.0f} m from the origin, more than cubes of {:g} mm can count; "
                      "give a larger --voxel-mm, or leave far points out with --max-distance-m",
                      point.position_m.norm(), 1000.0 * side_m_));
    }
    key = (key << kAxisBits) |
          static_cast<std::uint64_t>(static_cast<std::int64_t>(cube) + kHalfAxis);
    one.place[static_cast<std::size_t>(axis)] =
        static_cast<std::uint64_t>((cubes - cube) * kPlaceSteps);
  }
  voxels_[key].add(point.confidence, one);
}

void VoxelPoints::take(VoxelPoints* other) {
  for (const auto& [key, voxel] : other->voxels_) voxels_[key].add(1, voxel);
  other->voxels_.clear();
}

std::vector<CloudPoint> VoxelPoints::points() const {
  std::vector<std::uint64_t> keys;
  keys.reserve(voxels_.size());
  for (const auto& entry : voxels_) keys.push_back(entry.first);
  std::sort(keys.begin(), keys.end());
  std::vector<CloudPoint> points;
  points.reserve(keys.size());
  for (const std::uint64_t key : keys) {
    const Voxel& voxel = voxels_.at(key);
    const auto weight = static_cast<double>(voxel.weight);
    CloudPoint point{.confidence = voxel.confidence};
    Eigen::Vector3d place;
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      // Steps were rounded down.
      place[i] = (static_cast<double>(voxel.place[axis]) / weight + 0.5) / kPlaceSteps;
      point.colour[axis] =
          static_cast<std::uint8_t>(std::lround(static_cast<double>(voxel.colour[axis]) / weight));
    }
    point.position_m = side_m_ * (corner_of(key) + place);
    points.push_back(point);
  }
  return points;
}

std::int64_t write_points(const Room& room, const ExportOptions& options,
                          const std::filesystem::path& file) {
  const std::vector<MapStation> maps = all_maps(room);
  if (maps.empty()) {
    throw Error(room.directory().string() +
                ": has no distances to make points of; estimate them with raywalk-build-lf depth");
  }
  const VoxelPoints none(options.voxel_mm / 1000.0);
  VoxelPoints all = none;
  std::mutex mutex;
  {
    Progress progress("Collecting points", std::ssize(maps), "maps");
    parallel_for(0, static_cast<int>(maps.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        collect_points(room, maps[static_cast<std::size_t>(i)], options, none, &mutex, &all);
        progress.advance();
      }
    });
  }
  if (all.size() == 0) {
    throw Error(room.directory().string() +
                ": none of its distances is near enough and of sufficient confidence");
  }
  write_ply(file, all.points());
  return static_cast<std::int64_t>(all.size());
}

}  // namespace raywalk::build_lf
