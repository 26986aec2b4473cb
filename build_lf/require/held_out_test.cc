#include "build_lf/require/held_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "build_lf/require/test_distances.h"

namespace raywalk::build_lf {
namespace {

class HeldOutTest : public RequireTest {};

TEST_F(HeldOutTest, StridesGoUpToTheWholeLine) {
  const Room room = room_of({.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 64});
  const std::vector<HeldOutFacts> strides = measure_strides(room, 0.125, 0.5);
  std::vector<int> found;
  for (const HeldOutFacts& each : strides) {
    found.push_back(each.stride);
    EXPECT_NEAR(each.step_m, 0.125 * each.stride, 1e-9);
    EXPECT_EQ(each.views, 8 / each.stride);
  }
  EXPECT_THAT(found, ::testing::ElementsAre(2, 3, 4, 6, 8));
  EXPECT_GT(strides.front().psnr_without_depth_db, strides.back().psnr_without_depth_db + 6.0);
}

TEST_F(HeldOutTest, WrongDistancesLoseWithEveryStride) {
  const SyntheticRoomSpec spec{.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 256};
  const std::vector<HeldOutFacts> right = measure_strides(room_of(spec), 0.125, 0.5);
  replace_distances([](float metres) { return 1.3f * metres; });
  const std::vector<HeldOutFacts> wrong = measure_strides(Room::open(path_), 0.125, 0.5);
  ASSERT_EQ(wrong.size(), right.size());
  for (size_t i = 0; i < right.size(); ++i) {
    EXPECT_LT(wrong[i].psnr_with_distances_db, right[i].psnr_with_distances_db - 1.0) << i;
    EXPECT_GT(wrong[i].psnr_with_distances_db, wrong[i].psnr_without_depth_db + 3.0)
        << "a quarter of the parallax is left";
    EXPECT_EQ(wrong[i].psnr_without_depth_db, right[i].psnr_without_depth_db);
    EXPECT_EQ(wrong[i].psnr_of_tolerance_db, right[i].psnr_of_tolerance_db);
  }
}

TEST_F(HeldOutTest, TheToleranceIsThatOfADisplacedPicture) {
  SyntheticRoomSpec spec{.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 256};
  const Room room = room_of(spec);
  // Twice the displacement is four times the squared error where texture is coarse.
  EXPECT_NEAR(measure_strides(room, 0.125, 1.0).front().psnr_of_tolerance_db -
                  measure_strides(room, 0.125, 2.0).front().psnr_of_tolerance_db,
              6.0, 0.7);
  spec.scene.contrast = 0.0;
  EXPECT_EQ(measure_strides(room_of(spec), 0.125, 0.5).front().psnr_of_tolerance_db, 100.0)
      << "of a blank wall any displacement is right";
}

TEST_F(HeldOutTest, MaskedPixelsAreNotCompared) {
  SyntheticRoomSpec spec{.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 256};
  const auto measured = [&] { return measure_strides(room_of(spec), 0.125, 0.5).front(); };
  const HeldOutFacts clean = measured();
  spec.companion =
      CameraCompanion{.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
        return direction.y() < -0.8;
      }};
  const HeldOutFacts masked = measured();
  EXPECT_NEAR(masked.psnr_with_distances_db, clean.psnr_with_distances_db, 1.0);
  EXPECT_NEAR(masked.psnr_without_depth_db, clean.psnr_without_depth_db, 2.0);
  spec.companion->masked = false;
  EXPECT_LT(measured().psnr_with_distances_db, masked.psnr_with_distances_db - 5.0);
  spec.companion = CameraCompanion{
      .hides = [](const std::string&, int, const Eigen::Vector3d&) { return true; }};
  EXPECT_EQ(measured().psnr_with_distances_db, 100.0) << "nothing is compared";
}

TEST_F(HeldOutTest, StationsOffTheirLineAreRenderedAtTheirOwnPlace) {
  SyntheticRoomSpec spec{.cells_z = 0, .side_m = 2.0, .spacing_m = 0.125, .width = 256};
  spec.off_line = [](const std::string&, int station) {
    return station % 2 == 1 ? OffLine{.across_m = 0.03, .up_m = -0.02} : OffLine{};
  };
  const HeldOutFacts facts = measure_strides(room_of(spec), 0.125, 0.5).front();
  EXPECT_GT(facts.psnr_with_distances_db, 38.0);
  EXPECT_GT(facts.psnr_with_distances_db, facts.psnr_without_depth_db + 10.0);
}

TEST_F(HeldOutTest, LineOfTwoStationsHasNothingToLeaveOut) {
  EXPECT_TRUE(
      measure_strides(room_of({.cells_z = 0, .spacing_m = 1.0, .width = 64}), 1.0, 0.5).empty());
}

TEST(MeasuredUpTo, EndsBeforeTheFirstStepThatFails) {
  const auto step = [](double step_m, double psnr_db) {
    return HeldOutFacts{
        .step_m = step_m, .psnr_with_distances_db = psnr_db, .psnr_of_tolerance_db = 30.0};
  };
  EXPECT_EQ(
      measured_up_to_m(std::array{step(0.1, 40), step(0.2, 30), step(0.3, 29), step(0.4, 31)}),
      0.2);
  EXPECT_EQ(measured_up_to_m(std::array{step(0.1, 29), step(0.2, 31)}), 0.0);
  EXPECT_EQ(measured_up_to_m({}), 0.0);
}

}  // namespace
}  // namespace raywalk::build_lf
