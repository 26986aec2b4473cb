// Points thinned to one in each cube of a grid.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace raywalk::build_lf {

struct CloudPoint {
  Eigen::Vector3d position_m{0, 0, 0};
  std::array<std::uint8_t, 3> colour{0, 0, 0};  // red, green, blue
  std::uint8_t confidence = 0;                  // 1 to 255
};

// The mean of the points of each cube, weighted by their confidence. Sums are of whole numbers, so
// that the result does not depend on the order of the points.
class VoxelPoints {
 public:
  // What a cube takes in memory, about, with its share of the table.
  static constexpr std::size_t kBytes = 128;

  // `side_m` > 0. Of `parts` equal shares of the cubes, chosen by their hash, only those of `part`
  // are kept.
  VoxelPoints(double side_m, int parts, int part) : side_m_(side_m), parts_(parts), part_(part) {}

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
  };
  struct Hash {
    std::size_t operator()(std::uint64_t key) const;
  };

  double side_m_;
  int parts_;
  int part_;
  std::unordered_map<std::uint64_t, Voxel, Hash> voxels_{};
};

}  // namespace raywalk::build_lf
