#include "build_lf/require/held_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "build_lf/require/test_distances.h"

namespace raywalk::build_lf {
namespace {

class HeldOutTest : public RequireTest {
 protected:
  RecreationScore recreate(const Room& room, const HeldOutStation& station) const {
    return recreate_stations(room, room, std::array{station}, 0.5)[0];
  }
  // A line of 17 stations over 2 m.
  static SyntheticRoomSpec long_line() {
    return {.cells_z = 0, .side_m = 2.0, .spacing_m = 0.125, .width = 256};
  }
};

TEST_F(HeldOutTest, DistancesRemoveGhosts) {
  const Room room = room_of(long_line());
  const RecreationScore score = recreate(room, {0, 8, 6, 10});
  EXPECT_GT(score.psnr_with_distances_db, 38.0);
  EXPECT_LT(score.psnr_without_depth_db, 28.0);
  EXPECT_LT(score.hidden_share, 1e-3) << "nothing hides anything in an empty room";
}

TEST_F(HeldOutTest, SkyNeedsNoDistances) {
  SyntheticRoomSpec spec = long_line();
  spec.scene.infinitely_far = true;
  const RecreationScore score = recreate(room_of(spec), {0, 8, 0, 16});
  EXPECT_EQ(score.psnr_with_distances_db, 100.0);
  EXPECT_EQ(score.psnr_without_depth_db, 100.0);
}

TEST_F(HeldOutTest, WrongDistancesAreFound) {
  room_of(long_line());
  replace_distances([](float metres) { return 1.25f * metres; });
  const double wrong = recreate(Room::open(path_), {0, 8, 4, 12}).psnr_with_distances_db;
  const double right = recreate(room_of(long_line()), {0, 8, 4, 12}).psnr_with_distances_db;
  EXPECT_LT(wrong, right - 8.0);
}

TEST_F(HeldOutTest, OwnMapOfAStationLeftOutIsNotUsed) {
  SyntheticRoomSpec spec = long_line();
  const double with_all = recreate(room_of(spec), {0, 8, 6, 10}).psnr_with_distances_db;
  // Only the map of the station left out is wrong.
  room_of(spec);
  replace_distances([pixel = 0](float metres) mutable {
    const int map = pixel++ / (256 * 128);
    return map == 8 ? 0.3f : metres;
  });
  const double with_own_wrong = recreate(Room::open(path_), {0, 8, 6, 10}).psnr_with_distances_db;
  EXPECT_NEAR(with_own_wrong, with_all, 1e-9);
}

TEST_F(HeldOutTest, OccludedPointsAreReadFromTheOtherNeighbour) {
  SyntheticRoomSpec spec = long_line();
  spec.scene.obstacle = SceneBox{{-0.15, -0.5, 0.5}, {0.15, 0.5, 0.8}};
  spec.scene.texture_wavelength_m = 0.7;
  const RecreationScore score = recreate(room_of(spec), {0, 8, 4, 12});
  EXPECT_GT(score.psnr_with_distances_db, 27.0);
  EXPECT_GT(score.psnr_with_distances_db, score.psnr_without_depth_db + 7.0);
}

TEST_F(HeldOutTest, TolerancePsnrIsThatOfADisplacedPicture) {
  SyntheticRoomSpec flat = long_line();
  flat.scene.contrast = 0.0;
  EXPECT_EQ(recreate(room_of(flat), {0, 8, 6, 10}).psnr_of_tolerance_db, 100.0)
      << "of a blank wall any displacement is right";
  const Room room = room_of(long_line());
  const auto score_for = [&](double tolerance_px) {
    return recreate_stations(room, room, std::array{HeldOutStation{0, 8, 6, 10}}, tolerance_px)[0]
        .psnr_of_tolerance_db;
  };
  // Twice the displacement is four times the squared error where texture is coarse.
  EXPECT_NEAR(score_for(1.0) - score_for(2.0), 6.0, 0.7);
}

TEST_F(HeldOutTest, StridesGoUpToTheWholeLine) {
  const Room room = room_of({.cells_z = 0, .side_m = 1.0, .spacing_m = 0.125, .width = 64});
  const std::vector<HeldOutFacts> strides = measure_strides(room, 0.5);
  std::vector<int> found;
  for (const HeldOutFacts& each : strides) {
    found.push_back(each.stride);
    EXPECT_NEAR(each.step_m, 0.125 * each.stride, 1e-9);
    EXPECT_EQ(each.views, 8 / each.stride);
  }
  EXPECT_THAT(found, ::testing::ElementsAre(2, 3, 4, 6, 8));
  EXPECT_GT(strides.front().psnr_without_depth_db, strides.back().psnr_without_depth_db + 6.0);
}

TEST_F(HeldOutTest, LineOfTwoStationsHasNothingToLeaveOut) {
  EXPECT_TRUE(measure_strides(room_of({.cells_z = 0, .spacing_m = 1.0, .width = 64}), 0.5).empty());
}

TEST(PickEvenly, TakesAllIfFewOtherwiseEvenly) {
  std::vector<HeldOutStation> stations;
  for (int i = 0; i < 100; ++i) stations.push_back({.line = i / 50, .station = i % 50});
  const auto places = [&](int count) {
    std::vector<int> found;
    for (const HeldOutStation& each : pick_evenly(stations, count)) {
      found.push_back(50 * each.line + each.station);
    }
    return found;
  };
  // The middles of equal parts.
  EXPECT_THAT(places(4), ::testing::ElementsAre(12, 37, 62, 87));
  EXPECT_THAT(places(1), ::testing::ElementsAre(50));
  EXPECT_EQ(places(100).size(), 100U);
  EXPECT_EQ(places(101).size(), 100U);
  EXPECT_TRUE(pick_evenly({}, 12).empty());
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

TEST_F(HeldOutTest, MaskedPixelsAreNotCompared) {
  SyntheticRoomSpec spec = long_line();
  const RecreationScore clean = recreate(room_of(spec), {0, 8, 6, 10});
  spec.companion =
      CameraCompanion{.hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
        return direction.y() < -0.8;
      }};
  const RecreationScore masked = recreate(room_of(spec), {0, 8, 6, 10});
  EXPECT_NEAR(masked.psnr_with_distances_db, clean.psnr_with_distances_db, 1.0);
  EXPECT_NEAR(masked.psnr_without_depth_db, clean.psnr_without_depth_db, 1.0);
  spec.companion->color = {0, 255, 0};
  const RecreationScore recoloured = recreate(room_of(spec), {0, 8, 6, 10});
  EXPECT_EQ(recoloured.psnr_with_distances_db, masked.psnr_with_distances_db);
  // Half a pixel beside a pixel may be masked.
  EXPECT_NEAR(recoloured.psnr_of_tolerance_db, masked.psnr_of_tolerance_db, 1.0);
  spec.companion->masked = false;
  EXPECT_LT(recreate(room_of(spec), {0, 8, 6, 10}).psnr_with_distances_db,
            masked.psnr_with_distances_db - 5.0);
}

TEST_F(HeldOutTest, FullyMaskedRoomIsNotCompared) {
  SyntheticRoomSpec spec = long_line();
  spec.companion = CameraCompanion{
      .hides = [](const std::string&, int, const Eigen::Vector3d&) { return true; }};
  EXPECT_EQ(recreate(room_of(spec), {0, 8, 6, 10}).hidden_share, 1.0);
}

}  // namespace
}  // namespace raywalk::build_lf
