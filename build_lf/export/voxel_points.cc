#include "build_lf/export/voxel_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

constexpr int kBits = 21;  // of each axis in a key
constexpr std::int64_t kHalf = std::int64_t{1} << (kBits - 1);
constexpr std::uint64_t kAxisMask = (std::uint64_t{1} << kBits) - 1;
constexpr double kPlaceSteps = 65536.0;

struct Placed {
  std::uint64_t key = 0;
  std::array<std::uint64_t, 3> place{};
};

Placed placed(const Eigen::Vector3d& point_m, double side_m) {
  Placed result;
  for (const int axis : {1, 2, 0}) {
    const double cubes = point_m[axis] / side_m;
    const double cube = std::floor(cubes);
    if (!(std::abs(cube) < kHalf)) {
      throw Error(
          fmt::format("a point is {:.0f} m from the origin, more than cubes of {:g} mm can count; "
                      "give a larger "
                      "--voxel-mm, or leave far points out with --max-distance-m",
                      point_m.norm(), 1000.0 * side_m));
    }
    result.key =
        (result.key << kBits) | static_cast<std::uint64_t>(static_cast<std::int64_t>(cube) + kHalf);
    result.place[static_cast<std::size_t>(axis)] =
        static_cast<std::uint64_t>((cubes - cube) * kPlaceSteps);
  }
  return result;
}

// The corner of a cube, in cubes from the origin.
Eigen::Vector3d corner_of(std::uint64_t key) {
  const auto axis = [&](int shift) {
    return static_cast<double>(static_cast<std::int64_t>((key >> shift) & kAxisMask) - kHalf);
  };
  return {axis(0), axis(2 * kBits), axis(kBits)};
}

// The finaliser of SplitMix64 (Steele et al. 2014), which spreads neighbouring keys.
std::uint64_t mixed(std::uint64_t key) {
  key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9ULL;
  key = (key ^ (key >> 27)) * 0x94d049bb133111ebULL;
  return key ^ (key >> 31);
}

}  // namespace

std::size_t VoxelPoints::Hash::operator()(std::uint64_t key) const { return mixed(key); }

void VoxelPoints::add(const CloudPoint& point) {
  const Placed at = placed(point.position_m, side_m_);
  // By the upper bits, as the table uses the lower ones.
  const auto part = static_cast<int>((mixed(at.key) >> 32) % static_cast<std::uint64_t>(parts_));
  if (part != part_) return;
  Voxel& voxel = voxels_[at.key];
  const std::uint64_t weight = point.confidence;
  voxel.weight += weight;
  for (std::size_t i = 0; i < 3; ++i) {
    voxel.place[i] += weight * at.place[i];
    voxel.colour[i] += weight * point.colour[i];
  }
  voxel.confidence = std::max(voxel.confidence, point.confidence);
}

void VoxelPoints::take(VoxelPoints* other) {
  for (const auto& [key, from] : other->voxels_) {
    Voxel& voxel = voxels_[key];
    voxel.weight += from.weight;
    for (std::size_t i = 0; i < 3; ++i) {
      voxel.place[i] += from.place[i];
      voxel.colour[i] += from.colour[i];
    }
    voxel.confidence = std::max(voxel.confidence, from.confidence);
  }
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

}  // namespace raywalk::build_lf
