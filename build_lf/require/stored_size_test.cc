#include "build_lf/require/stored_size.h"

#include <gtest/gtest.h>

#include <cmath>

#include "build_lf/require/test_distances.h"
#include "core/geometry/error_model.h"
#include "core/geometry/spacing.h"

namespace raywalk::build_lf {
namespace {

class StoredSizeTest : public RequireTest {};

TEST(UsefulWidth, IsWhereResidualParallaxEqualsTheTolerance) {
  const StorageNeed need{
      .reach_m = 0.5, .spacing_m = 0.0, .tolerance_px = 0.5, .omega_error = 0.01};
  const double width_px = useful_width(need);
  // Independent computation: the largest latitude error for a source at 4 m with a wrong distance.
  double worst_rad = 0.0;
  for (int degree = 0; degree <= 90; ++degree) {
    const double alpha_rad = radians_from_degrees(degree);
    const double wrong_m = 1.0 / (0.25 + 0.01);
    worst_rad = std::max(worst_rad, std::abs(latitude_shift(4.0, alpha_rad, 0.5) -
                                             latitude_shift(wrong_m, alpha_rad, 0.5)));
  }
  EXPECT_NEAR(worst_rad, angle_of_pixels(0.5, static_cast<int>(width_px)), 0.05 * worst_rad);
}

TEST(UsefulWidth, FallsWithErrorReachAndSpacing) {
  const StorageNeed need{
      .reach_m = 0.5, .spacing_m = 0.2, .tolerance_px = 0.5, .omega_error = 0.01};
  const double width_px = useful_width(need);
  const auto with = [&](double StorageNeed::*member, double factor) {
    StorageNeed other = need;
    other.*member *= factor;
    return useful_width(other);
  };
  EXPECT_LT(with(&StorageNeed::reach_m, 2.0), 0.6 * width_px);
  EXPECT_LT(with(&StorageNeed::spacing_m, 10.0), 0.6 * width_px);
  EXPECT_DOUBLE_EQ(with(&StorageNeed::omega_error, 2.0), 0.5 * width_px);
  EXPECT_TRUE(std::isinf(with(&StorageNeed::omega_error, 0.0)));
}

TEST_F(StoredSizeTest, SmoothDistancesNeedCoarseMapsAndDetailedOnesFine) {
  SyntheticRoomSpec spec{.cells_z = 0, .side_m = 1.0, .spacing_m = 0.5, .width = 512};
  const StorageNeed need{.reach_m = 0.5, .tolerance_px = 0.5};
  const DistanceWidth smooth = distance_width_needed(room_of(spec), need);
  EXPECT_LE(smooth.width_px, 128);
  EXPECT_GE(smooth.share_within_tolerance, kKeptShare);
  // Stripes of 2 pixels alternate between two distances: half the width cannot hold them.
  replace_distances([pixel = 0](float metres) mutable {
    const int theta = pixel++ / 256;
    return theta / 2 % 2 == 0 ? metres : 0.6f * metres;
  });
  EXPECT_GT(distance_width_needed(Room::open(path_), need).width_px, 128);
  EXPECT_LT(smooth.width_px, distance_width_needed(Room::open(path_), need).width_px);
}

TEST_F(StoredSizeTest, TighterToleranceNeedsFinerMaps) {
  const Room room = room_of({.cells_z = 0, .side_m = 1.0, .spacing_m = 0.5, .width = 512});
  const auto width_for = [&](double tolerance_px) {
    return distance_width_needed(room, {.reach_m = 0.5, .tolerance_px = tolerance_px}).width_px;
  };
  EXPECT_LT(width_for(1.0), width_for(0.02));
}

TEST_F(StoredSizeTest, BytesAreThoseOfTheFilesWithoutHeaders) {
  const Room room = room_of({.width = 64, .distance_every = 2, .distance_width = 32});
  // 9 stations and 5 maps on each of 4 lines.
  const StorageFacts facts = storage_facts(room,
                                           {.reach_m = 0.5,
                                            .spacing_m = 0.125,
                                            .tolerance_px = 0.5,
                                            .omega_error = 0.01,
                                            .scene = {0.2, 1.0}},
                                           10);
  EXPECT_EQ(facts.ray_bytes, 36U * 64 * 32 * 3);
  EXPECT_EQ(facts.ray_bytes_thinned, 10U * 64 * 32 * 3);
  EXPECT_EQ(facts.ray_bytes_worth, facts.ray_bytes_thinned) << "a wider panorama would be of use";
  EXPECT_EQ(facts.distance_bytes, 20U * 32 * 16 * 5);
  EXPECT_EQ(facts.distance_width_px, 32);
  EXPECT_EQ(facts.omega_steps, layers_for_tolerance({0.2, 1.0}, 0.5, angle_of_pixels(0.5, 64)));
  EXPECT_EQ(facts.omega_bits, static_cast<int>(std::ceil(std::log2(facts.omega_steps + 2))));
  EXPECT_LT(facts.distance_bytes_needed, facts.distance_bytes);
}

}  // namespace
}  // namespace raywalk::build_lf
