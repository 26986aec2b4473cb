#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "build_lf/require/scene_facts.h"
#include "build_lf/require/test_distances.h"

namespace raywalk::build_lf {
namespace {

class OmegaErrorTest : public RequireTest {};

TEST_F(OmegaErrorTest, ExactMapsHaveNearlyNoError) {
  const auto error = omega_error(room_of({.width = 256}));
  ASSERT_TRUE(error);
  EXPECT_LT(*error, 2e-3);
}

TEST_F(OmegaErrorTest, NoiseIsMeasured) {
  room_of({.width = 256});
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 0.005);  // 1/m; 95 % are within 1.96 of it
  replace_distances(
      [&](float metres) { return static_cast<float>(1.0 / (1.0 / metres + noise(random))); });
  const auto error = omega_error(Room::open(path_));
  ASSERT_TRUE(error);
  // Interpolation reduces the noise of one of the two maps.
  EXPECT_NEAR(*error, 1.96 * 0.005, 0.35 * 1.96 * 0.005);
}

TEST_F(OmegaErrorTest, OneMapHasNothingToCompareWith) {
  EXPECT_FALSE(omega_error(room_of({.cells_z = 0, .width = 64, .distance_every = 1000})));
  EXPECT_FALSE(omega_error(room_of({.width = 64, .distances = false})));
}

TEST_F(OmegaErrorTest, DistancesThatViewsIgnoreDoNotCount) {
  room_of({.width = 64});
  replace_distances([](float metres) { return metres; }, kMinConfidence);
  EXPECT_TRUE(omega_error(Room::open(path_)));
  replace_distances([](float metres) { return metres; }, kMinConfidence - 1);
  EXPECT_FALSE(omega_error(Room::open(path_)));
}

TEST_F(OmegaErrorTest, SkyIsAgreement) {
  SyntheticRoomSpec spec{.width = 64};
  spec.scene.infinitely_far = true;
  // Sky is stored as infinity.
  EXPECT_EQ(omega_error(room_of(spec)), 0.0);
}

}  // namespace
}  // namespace raywalk::build_lf
