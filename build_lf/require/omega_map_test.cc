#include "build_lf/require/omega_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk::build_lf {
namespace {

OmegaMap true_map(const SyntheticScene& scene, const Eigen::Vector3d& position_m, int width) {
  OmegaMap map({width, width / 2});
  for (int theta = 0; theta < width; ++theta) {
    for (int row = 0; row < width / 2; ++row) {
      const PixelPosition pixel{static_cast<double>(theta), static_cast<double>(row)};
      map.at(theta, row) = static_cast<float>(
          1.0 / distance_at(scene, position_m,
                            direction_from_angles(angles_from_pixel(pixel, map.size()))));
    }
  }
  return map;
}

// Share of pixels (by solid angle) within `tolerance` of the truth, relative.
double share_right(const OmegaMap& map, const OmegaMap& truth, double tolerance) {
  double right = 0.0, all = 0.0;
  for (int theta = 0; theta < map.size().width; ++theta) {
    for (int row = 0; row < map.size().height; ++row) {
      const double part =
          std::cos(angles_from_pixel({0.0, static_cast<double>(row)}, map.size()).phi_rad);
      const double error = std::abs(map.at(theta, row) - truth.at(theta, row));
      if (error <= tolerance * truth.at(theta, row)) right += part;
      all += part;
    }
  }
  return right / all;
}

TEST(OmegaMap, SeenPointMatchesGeometryAtAnyScale) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return Eigen::Vector3d(unit(random), unit(random), unit(random)); };
  for (int i = 0; i < 1000; ++i) {
    const double scale = std::pow(10.0, 6.0 * unit(random));
    const Eigen::Vector3d point = scale * vector();
    const Eigen::Vector3d offset = scale * vector();  // of here, from there
    const auto omega = static_cast<float>(1.0 / point.norm());
    const SeenPoint seen = seen_from(point.normalized(), omega, offset);
    const Eigen::Vector3d from_there = point + offset;
    EXPECT_LT((direction_from_angles(seen.angles) - from_there.normalized()).norm(),
              2e-7 * (point.norm() + offset.norm()) / from_there.norm());
    EXPECT_NEAR(seen.omega * from_there.norm(), 1.0,
                2e-7 * (point.norm() + offset.norm()) / from_there.norm());
  }
}

TEST(OmegaMap, SkyDoesNotMove) {
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, -3).normalized();
  const SeenPoint seen = seen_from(direction, 0.0f, {1e6, 5, 1});
  EXPECT_EQ(seen.omega, 0.0f);
  EXPECT_LT((direction_from_angles(seen.angles) - direction).norm(), 1e-12);
}

TEST(OmegaMap, ProjectionMatchesTheTruth) {
  SyntheticScene scene;
  const Eigen::Vector3d here(0.1, 0.0, 0.0);
  const OmegaMap left = true_map(scene, {-0.4, 0, 0}, 256),
                 right = true_map(scene, {0.5, 0, 0}, 256);
  const OmegaMap truth = true_map(scene, here, 256);
  const std::array maps{PlacedMap{&left, {-0.4, 0, 0}}, PlacedMap{&right, {0.5, 0, 0}}};
  const OmegaMap seen = projected(maps, here, 256);
  EXPECT_GT(share_right(seen, truth, 2e-3), 0.97) << "walls meet at edges, elsewhere it is exact";
  EXPECT_GT(share_right(seen, truth, 0.1), 0.999);
}

TEST(OmegaMap, ObstacleOccludesTheBackground) {
  SyntheticScene scene;
  scene.obstacle = SceneBox{{-0.3, -0.6, 1.0}, {0.4, 0.5, 1.4}};
  const Eigen::Vector3d here(0.0, 0.0, 0.0);
  const OmegaMap left = true_map(scene, {-0.3, 0, 0}, 256),
                 right = true_map(scene, {0.3, 0, 0}, 256);
  const std::array maps{PlacedMap{&left, {-0.3, 0, 0}}, PlacedMap{&right, {0.3, 0, 0}}};
  const OmegaMap truth = true_map(scene, here, 256);
  EXPECT_GT(share_right(projected(maps, here, 256), truth, 0.02), 0.98);
  // One map alone is wrong about the background beside the obstacle.
  EXPECT_LT(share_right(left, truth, 0.02), 0.8);
}

TEST(OmegaMap, UnknownPixelsTakeTheFartherNeighbour) {
  OmegaMap map({8, 4});
  map.at(1, 2) = 0.5f;
  map.at(5, 2) = 0.25f;
  const std::array maps{PlacedMap{&map, {0, 0, 0}}};
  const OmegaMap filled = projected(maps, {0, 0, 0}, 8);
  EXPECT_EQ(filled.at(1, 2), 0.5f);
  EXPECT_EQ(filled.at(3, 2), 0.25f);
  EXPECT_EQ(filled.at(7, 2), 0.25f) << "rows go round";
  EXPECT_LT(filled.at(0, 0), 0.0f) << "a row of which nothing is known";
}

TEST(OmegaMap, SamplesDoNotMixSurfaces) {
  OmegaMap map({64, 32});
  for (int theta = 0; theta < 64; ++theta) {
    for (int row = 0; row < 32; ++row) map.at(theta, row) = theta < 32 ? 1.0f : 0.1f;
  }
  EXPECT_EQ(map.sample({31.4, 10.0}), 1.0f);
  EXPECT_EQ(map.sample({31.6, 10.0}), 0.1f);
  map.at(31, 10) = -1.0f;
  EXPECT_LT(map.sample({31.4, 10.0}), 0.0f);
}

TEST(OmegaMap, ResizedPlaneIsTheSamePlane) {
  SyntheticScene scene;
  const OmegaMap fine = true_map(scene, {0, 0, 0}, 512), coarse = true_map(scene, {0, 0, 0}, 128);
  EXPECT_GT(share_right(resized(fine, 128), coarse, 2e-3), 0.97);
}

}  // namespace
}  // namespace raywalk::build_lf
