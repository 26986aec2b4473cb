#include "core/room/omega_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk {
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
}  // namespace raywalk
