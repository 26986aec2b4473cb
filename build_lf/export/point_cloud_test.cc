#include "build_lf/export/point_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/test_error.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;

TEST(VoxelPoints, AreTheWeightedMeansOfTheirCubes) {
  VoxelPoints voxels(0.1);
  voxels.add({{0.01, 0.02, -0.03}, {100, 0, 10}, 100});
  voxels.add({{0.05, 0.02, -0.03}, {200, 0, 10}, 200});
  voxels.add({{0.15, 0.02, -0.03}, {1, 2, 3}, 64});
  const std::vector<CloudPoint> points = voxels.points();
  ASSERT_EQ(points.size(), 2U);
  EXPECT_NEAR(points[0].position_m.x(), (0.01 + 2 * 0.05) / 3, 2e-6);
  EXPECT_NEAR(points[0].position_m.z(), -0.03, 2e-6);
  EXPECT_EQ(points[0].colour[0], 167);
  EXPECT_EQ(points[0].confidence, 200);
  EXPECT_NEAR(points[1].position_m.x(), 0.15, 2e-6);
}

TEST(VoxelPoints, JoiningIsAsAdding) {
  std::vector<CloudPoint> cloud;
  for (int i = 0; i < 500; ++i) {
    cloud.push_back({{0.013 * i, std::sin(i), 0.5 * std::cos(3.0 * i)}, {9, 8, 7}, 100});
  }
  VoxelPoints whole(0.05);
  VoxelPoints joined(0.05);
  VoxelPoints other(0.05);
  for (const CloudPoint& point : cloud) whole.add(point);
  for (std::size_t i = 0; i < cloud.size(); ++i) (i % 3 == 0 ? joined : other).add(cloud[i]);
  joined.take(&other);
  EXPECT_EQ(other.size(), 0U);
  ASSERT_EQ(joined.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(joined.points()[i].position_m, whole.points()[i].position_m);
  }
}

TEST(VoxelPoints, TooFarToCountAreAnError) {
  VoxelPoints voxels(0.001);
  EXPECT_THAT(error_of([&] {
                voxels.add({{0, 0, 5000}, {}, 255});
              }),
              HasSubstr("--max-distance-m"));
}

}  // namespace
}  // namespace raywalk::build_lf
