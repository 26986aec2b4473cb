// The points of a room's distances, coloured, for measuring tools.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <unordered_map>
#include <vector>

#include "build_lf/export/export_room.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Writes a PLY (binary, little-endian) of one point in each cube of options.voxel_mm: float x, y, z
// in metres (x right, y forward, z up: right-handed), uchar red, green, blue, confidence (64 to
// 255). Returns the number of points. Takes about 128 bytes of memory for each. Throws Error if the
// room has no distances, none of them counts, or the file cannot be written; then there is none.
std::int64_t write_points(const Room& room, const ExportOptions& options,
                          const std::filesystem::path& file);

// The text by which such a file is known.
inline constexpr const char* kPointsSignature = "comment Raywalk";

struct CloudPoint {
  Eigen::Vector3d position_m{0, 0, 0};
  std::array<std::uint8_t, 3> colour{0, 0, 0};  // red, green, blue
  std::uint8_t confidence = 0;                  // 1 to 255
};

// The mean of the points in each cube of a grid, weighted by their confidence. Sums are of whole
// numbers, so that the result does not depend on the order of the points.
class VoxelPoints {
 public:
  explicit VoxelPoints(double side_m) : side_m_(side_m) {}  // > 0

  // Throws Error for a point more than 2^20 cubes from the origin.
  void add(const CloudPoint& point);
  // Adds the sums of another one of the same side, and empties it.
  void take(VoxelPoints* other);

  std::size_t size() const { return voxels_.size(); }
  // In the order of the cubes: by y, z, x of the world. The highest confidence of each cube.
  std::vector<CloudPoint> points() const;

 private:
  struct Voxel {
    std::uint64_t weight = 0;
    std::array<std::uint64_t, 3> place{};  // in the cube, in steps of side / 2^16
    std::array<std::uint64_t, 3> colour{};
    std::uint8_t confidence = 0;
    void add(std::uint64_t times, const Voxel& other);
  };
  struct Hash {
    std::size_t operator()(std::uint64_t key) const;
  };

  double side_m_;
  std::unordered_map<std::uint64_t, Voxel, Hash> voxels_{};
};

}  // namespace raywalk::build_lf
