#include "build_lf/require/scene_facts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "build_lf/require/test_distances.h"
#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class SceneFactsTest : public RequireTest {};

TEST_F(SceneFactsTest, RangesAreThoseOfTheRoom) {
  SyntheticRoomSpec spec{.side_m = 0.2, .spacing_m = 0.1, .width = 128};
  spec.scene.walls = {{-4.0, -1.0, -2.0}, {3.0, 1.5, 5.0}};
  const DistanceFacts facts = distance_facts(room_of(spec));
  // The floor is nearest, 1 m below; the farthest edge lies beyond the wall 5 m ahead.
  EXPECT_NEAR(facts.near_m, 1.0, 0.03);
  EXPECT_GT(facts.far_m, 5.0);
  EXPECT_LT(facts.near_m, facts.median_m);
  EXPECT_EQ(facts.sky_share, 0.0);
  EXPECT_NEAR(facts.known_share, 1.0, 1e-6);
}

TEST_F(SceneFactsTest, SkyIsInfinitelyFar) {
  SyntheticRoomSpec spec{.width = 64};
  spec.scene.infinitely_far = true;
  const DistanceFacts facts = distance_facts(room_of(spec));
  EXPECT_TRUE(std::isinf(facts.near_m));
  EXPECT_EQ(facts.sky_share, 1.0);
  const LayerFacts layers = layer_facts(facts, 0.5, 1e-3);
  EXPECT_EQ(layers.omega_max_per_m, 0.0);
  for (const LayersAtDistance& each : layers.by_d_p) EXPECT_EQ(each.layers, 1);
}

TEST_F(SceneFactsTest, PixelsAreWeightedByConfidence) {
  room_of({.width = 64});
  replace_distances([](float metres) { return metres; }, 51);
  EXPECT_NEAR(distance_facts(Room::open(path_)).known_share, 0.2, 1e-3);
}

TEST_F(SceneFactsTest, RoomWithoutKnownDistancesIsAnError) {
  const auto message_of = [](const Room& room) -> std::string {
    try {
      distance_facts(room);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const auto names_both =
      AllOf(HasSubstr(path_.string()), HasSubstr("raywalk-build-lf depth"),
            HasSubstr("raywalk-build-lf pack --distance"), ::testing::Not(HasSubstr("\n")));
  EXPECT_THAT(message_of(room_of({.width = 32, .distances = false})), names_both);
  room_of({.width = 32});
  replace_distances([](float metres) { return metres; }, 0);
  EXPECT_THAT(message_of(Room::open(path_)), names_both) << "maps of confidence 0 know nothing";
}

TEST(LayerFactsTest, AreCountedForTheRangeAndEachDistance) {
  const LayerFacts facts = layer_facts({.near_m = 0.5, .far_m = INFINITY}, 0.5, 1e-3);
  EXPECT_EQ(facts.omega_min_per_m, 0.0);
  EXPECT_EQ(facts.omega_max_per_m, 2.0);
  int last = 0;
  for (const LayersAtDistance& each : facts.by_d_p) {
    EXPECT_EQ(each.layers, layers_for_tolerance({0.0, 2.0}, each.d_p_m, 1e-3));
    EXPECT_GT(each.layers, last);
    last = each.layers;
  }
}

TEST(TypicalReach, IsHalfTheSmallestCell) {
  EXPECT_DOUBLE_EQ(typical_reach_m(synthetic_grid({.cells_x = 2, .cells_z = 3, .side_m = 0.8})),
                   0.4);
  EXPECT_DOUBLE_EQ(typical_reach_m(synthetic_grid({.cells_z = 0, .side_m = 3.0})), 1.5);
}

}  // namespace
}  // namespace raywalk::build_lf
