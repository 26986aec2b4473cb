#include "build_lf/depth/tile_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace raywalk::build_lf {
namespace {

constexpr double kPixel_per_m = 0.02;

Eigen::Vector3d direction_of(int theta, int phi, PanoramaSize size) {
  return direction_from_angles(angles_from_pixel({double(theta), double(phi)}, size));
}

using OmegaOf = std::function<double(const Eigen::Vector3d&)>;

InverseDistanceMap map_of(const OmegaOf& omega_of, PanoramaSize size = {256, 128}) {
  InverseDistanceMap map{{}, {0, 0, 0}, size, {}, {}};
  for (int theta = 0; theta < size.width; ++theta) {
    for (int phi = 0; phi < size.height; ++phi) {
      map.omega.push_back(static_cast<float>(omega_of(direction_of(theta, phi, size))));
    }
  }
  map.confidence.assign(map.omega.size(), 255);
  return map;
}

// How far the nearest of a tile's planes is from `omega_of`, at most, over the tile.
double largest_error(const TilePlanes& planes, int column, int row, const OmegaOf& omega_of,
                     PanoramaSize size = {256, 128}) {
  double least = 1e9;
  for (const Plane& plane : planes.around(column, row, 9)) {
    double largest = 0.0;
    for (int i = 0; i < kPlaneTile * kPlaneTile; ++i) {
      const Eigen::Vector3d direction = direction_of(column * kPlaneTile + i / kPlaneTile,
                                                     row * kPlaneTile + i % kPlaneTile, size);
      largest =
          std::max(largest, std::fabs(plane.cast<double>().dot(direction) - omega_of(direction)));
    }
    least = std::min(least, largest);
  }
  return least;
}

// A wall at z = 2 m; what is not in front of it is infinitely far.
double wall(const Eigen::Vector3d& direction) { return std::max(0.0, direction.z() / 2.0); }

// The wall, and a post at 1 m in front of it, 18 pixels of 256 wide.
bool on_post(const Eigen::Vector3d& direction) {
  return std::fabs(std::atan2(direction.x(), direction.z())) < 0.22;
}
double post(const Eigen::Vector3d& direction) { return on_post(direction) ? 1.0 : wall(direction); }

TEST(TilePlanesTest, ASlantedWallIsOnePlane) {
  const TilePlanes planes(map_of(wall), kPixel_per_m);
  for (const int column : {33, 36, 40, 44}) {
    EXPECT_LT(largest_error(planes, column, 16, wall), 0.25 * kPixel_per_m) << column;
  }
}

TEST(TilePlanesTest, BesideASilhouetteAndBehindThePlanesOfBothSidesAreKnown) {
  const TilePlanes planes(map_of(post), kPixel_per_m);
  for (int column = 28; column < 36; ++column) {
    EXPECT_LT(largest_error(planes, column, 16, [](const auto&) { return 1.0; }), kPixel_per_m)
        << column;
    EXPECT_LT(largest_error(planes, column, 16, wall), 0.5 * kPixel_per_m) << column;
  }
}

TEST(TilePlanesTest, NearAndCommonPlanesComeFirst) {
  const TilePlanes planes(map_of(post), kPixel_per_m);
  EXPECT_EQ(planes.around(32, 16, 1).size(), 1U);
  EXPECT_NEAR(planes.around(32, 16, 1)[0].dot(Eigen::Vector3f(0, 0, 1)), 1.0, kPixel_per_m);
}

TEST(TilePlanesTest, SingleWrongValuesDoNotBendAPlane) {
  InverseDistanceMap map = map_of(wall);
  for (std::size_t pixel = 0; pixel < map.omega.size(); pixel += 7) map.omega[pixel] += 0.3f;
  const TilePlanes planes(map, kPixel_per_m);
  EXPECT_LT(largest_error(planes, 38, 16, wall), 0.2 * kPixel_per_m);
}

TEST(TilePlanesTest, WhatIsNotKnownHasNone) {
  InverseDistanceMap map = map_of(wall);
  map.confidence.assign(map.confidence.size(), 0);
  EXPECT_TRUE(TilePlanes(map, kPixel_per_m).around(32, 16, 9).empty());
}

// Poles, the seam, and heights that are no multiple of a tile.
TEST(TilePlanesTest, CoverTheWholeSphereAtAnySize) {
  const auto floor = [](const Eigen::Vector3d& direction) { return -direction.y() / 1.5; };
  const auto seen = [&](const Eigen::Vector3d& direction) {
    return std::max(0.0, floor(direction));
  };
  for (const PanoramaSize size : {PanoramaSize{32, 16}, {36, 18}, {256, 128}, {1024, 512}}) {
    const TilePlanes planes(map_of(seen, size), 8.0 / size.width);
    EXPECT_EQ(planes.columns() * kPlaneTile, size.width);
    EXPECT_GE(planes.rows() * kPlaneTile, size.height);
    const int lowest = size.height / kPlaneTile - 1;
    for (const int column : {0, planes.columns() / 2, planes.columns() - 1}) {
      for (const int row : {lowest, lowest - 1}) {
        EXPECT_LT(largest_error(planes, column, row, floor, size), 4.0 / size.width)
            << size.width << ' ' << column << ' ' << row;
      }
      for (int row = 0; row < planes.rows(); ++row) {
        for (const Plane& plane : planes.around(column, row, 9)) EXPECT_TRUE(plane.allFinite());
      }
    }
  }
}

}  // namespace
}  // namespace raywalk::build_lf
