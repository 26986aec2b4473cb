#include "build_lf/depth/depth_truth.h"

#include <gmock/gmock.h>

#include <cmath>

#include "build_lf/depth/depth_test_room.h"
#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

constexpr PanoramaSize kTruthSize{64, 32};

class DepthTruthTest : public ::testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec small = room_of_scale(1.0);
    small.width = kTruthSize.width;
    return small;
  }
  // Maps at every eighth station: the truth, modified by `change(pixel, map)`.
  template <typename Change>
  TruthComparison compare(const Change& change) {
    PartialMaps partial(room_.room().directory(), "inputs");
    for (const SweepReference& reference : plan_.maps) {
      InverseDistanceMap map = true_map(spec().scene, reference.position_m, plan_.size);
      map.station = reference.station;
      for (size_t pixel = 0; pixel < map.omega.size(); ++pixel) change(pixel, &map);
      partial.store("final", map);
    }
    return compare_with_truth(GivenDistances(room_.room()), plan_, partial);
  }
  // A pixel of parallax at the reach, 1/m.
  double pixel_per_m() const { return kTwoPi / kTruthSize.width / plan_.reach_m; }

  DepthTestRoom room_{spec()};
  DepthPlan plan_ = plan_depth(room_.room(), {.every = 8});
};

TEST_F(DepthTruthTest, ExactMapsHaveNoError) {
  room_.give_distances(spec().scene, kTruthSize);
  const TruthComparison comparison = compare([](size_t, InverseDistanceMap*) {});
  EXPECT_EQ(comparison.maps, 12);
  EXPECT_EQ(comparison.within_1px_share, 1.0);
  EXPECT_LT(comparison.median_relative_error, 1e-4);
  ASSERT_THAT(comparison.elsewhere, SizeIs(1));
  EXPECT_EQ(comparison.elsewhere[0].pixels, 12 * kTruthSize.width * kTruthSize.height);
  EXPECT_EQ(comparison.elsewhere[0].wrong_share, 0.0);
}

TEST_F(DepthTruthTest, CountsErrorsInPixelsOfParallax) {
  room_.give_distances(spec().scene, kTruthSize);
  // A quarter of the pixels each is off by 0.5, 1.5, 3 and 5 pixels.
  const TruthComparison comparison = compare([&](size_t pixel, InverseDistanceMap* map) {
    const std::array<double, 4> off_px{0.5, 1.5, 3.0, 5.0};
    map->omega[pixel] += static_cast<float>(off_px[pixel % 4] * pixel_per_m());
  });
  EXPECT_DOUBLE_EQ(comparison.within_1px_share, 0.25);
  EXPECT_DOUBLE_EQ(comparison.within_2px_share, 0.5);
  EXPECT_DOUBLE_EQ(comparison.within_4px_share, 0.75);
}

TEST_F(DepthTruthTest, MedianErrorIsRelativeToTheDistance) {
  room_.give_distances(spec().scene, kTruthSize);
  for (const double error : {0.02, -0.05, 0.2}) {
    const TruthComparison comparison = compare([&](size_t pixel, InverseDistanceMap* map) {
      // A few gross errors do not move a median.
      map->omega[pixel] *= static_cast<float>(pixel % 3 == 0 ? 100.0 : 1.0 + error);
    });
    EXPECT_NEAR(comparison.median_relative_error, std::fabs(error), 1e-4);
  }
}

TEST_F(DepthTruthTest, CalibrationGroupsErrorsByConfidence) {
  room_.give_distances(spec().scene, kTruthSize);
  const TruthComparison comparison = compare([&](size_t pixel, InverseDistanceMap* map) {
    const bool sure = pixel % 2 == 0;
    map->confidence[pixel] = sure ? 250 : 10;
    const bool wrong = sure ? pixel % 16 == 0 : pixel % 4 == 1;
    if (wrong) map->omega[pixel] += static_cast<float>(3.0 * pixel_per_m());
  });
  ASSERT_THAT(comparison.elsewhere, SizeIs(2));
  const ConfidenceBand& unsure = comparison.elsewhere[0];
  const ConfidenceBand& sure = comparison.elsewhere[1];
  EXPECT_LT(unsure.confidence, 0.125);
  EXPECT_GT(sure.confidence, 0.875);
  EXPECT_EQ(unsure.pixels, sure.pixels);
  EXPECT_DOUBLE_EQ(unsure.wrong_share, 0.5);
  EXPECT_DOUBLE_EQ(sure.wrong_share, 0.125);
  EXPECT_LT(sure.median_error_px, 0.01);
}

// The scene has a box in front of a wall: 2 pixels beside its outline count with the edges.
TEST_F(DepthTruthTest, SilhouettesAreJudgedByThemselves) {
  SyntheticRoomSpec with_box = spec();
  with_box.scene.obstacle = SceneBox{{-0.2, -0.2, 0.9}, {0.2, 0.2, 1.0}};
  room_.give_distances(with_box.scene, kTruthSize);
  PartialMaps partial(room_.room().directory(), "inputs");
  std::int64_t pixels = 0;
  for (const SweepReference& reference : plan_.maps) {
    InverseDistanceMap map = true_map(with_box.scene, reference.position_m, plan_.size);
    map.station = reference.station;
    const InverseDistanceMap without = true_map(spec().scene, reference.position_m, plan_.size);
    for (size_t pixel = 0; pixel < map.omega.size(); ++pixel, ++pixels) {
      const bool outline = pixel >= 2 && map.omega[pixel] != without.omega[pixel] &&
                           map.omega[pixel - 2] == without.omega[pixel - 2];
      if (outline) map.omega[pixel - 2] = map.omega[pixel];
    }
    partial.store(kFinalStage, map);
  }
  const TruthComparison comparison =
      compare_with_truth(GivenDistances(room_.room()), plan_, partial);
  ASSERT_THAT(comparison.edges, SizeIs(1));
  ASSERT_THAT(comparison.elsewhere, SizeIs(1));
  EXPECT_EQ(comparison.edges[0].pixels + comparison.elsewhere[0].pixels, pixels);
  EXPECT_LT(comparison.edges[0].pixels, pixels / 4);
  EXPECT_GT(comparison.edges[0].wrong_share, 0.05);
  EXPECT_EQ(comparison.elsewhere[0].wrong_share, 0.0);
}

TEST_F(DepthTruthTest, InfinityIsComparedAsParallax) {
  SyntheticScene sky = spec().scene;
  sky.infinitely_far = true;
  room_.give_distances(sky, kTruthSize);
  const TruthComparison right =
      compare([](size_t pixel, InverseDistanceMap* map) { map->omega[pixel] = 0.0f; });
  EXPECT_EQ(right.within_1px_share, 1.0);
  EXPECT_TRUE(std::isfinite(right.median_relative_error));
  const TruthComparison wrong = compare([&](size_t pixel, InverseDistanceMap* map) {
    map->omega[pixel] = static_cast<float>(1.5 * pixel_per_m());
  });
  EXPECT_EQ(wrong.within_1px_share, 0.0);
  EXPECT_EQ(wrong.within_2px_share, 1.0);
}

TEST_F(DepthTruthTest, ComparesMapsOfAnotherSize) {
  room_.give_distances(spec().scene, {4 * kTruthSize.width, 2 * kTruthSize.width});
  const TruthComparison comparison = compare([](size_t, InverseDistanceMap*) {});
  EXPECT_GT(comparison.within_1px_share, 0.98);
}

TEST_F(DepthTruthTest, OnlyStationsWithBothMapsCount) {
  room_.give_distances(spec().scene, kTruthSize, 16);
  EXPECT_EQ(compare([](size_t, InverseDistanceMap*) {}).maps, 8);
  EXPECT_FALSE(GivenDistances(room_.room()).omega_of({0, 8}, kTruthSize).has_value());
}

TEST_F(DepthTruthTest, NothingToCompareIsAnError) {
  room_.give_distances(spec().scene, kTruthSize, 16);
  std::erase_if(plan_.maps,
                [](const SweepReference& map) { return map.station.station % 16 == 0; });
  EXPECT_THAT([&] { compare([](size_t, InverseDistanceMap*) {}); },
              ThrowsMessage<Error>(HasSubstr("--every")));
}

TEST_F(DepthTruthTest, GivenDistancesAreFoundWhereOthersAreInUse) {
  EXPECT_TRUE(GivenDistances(room_.room()).empty());
  room_.give_distances(spec().scene, kTruthSize);
  const GivenDistances in_use(room_.room());
  const auto before = in_use.omega_of({1, 4}, kTruthSize);
  ASSERT_TRUE(before.has_value());
  EXPECT_THAT(*before, Each(::testing::Gt(0.0f)));
  const std::filesystem::path directory = room_.room().directory();
  const GivenDistances unused(Room::open_rays(directory));
  EXPECT_FALSE(unused.empty());
  EXPECT_EQ(unused.omega_of({1, 4}, kTruthSize), before);
}

}  // namespace
}  // namespace raywalk::build_lf
