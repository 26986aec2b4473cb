#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "core/room/distance_maps.h"
#include "core/room/distance_volume.h"
#include "tests/synthetic_room/synthetic_room.h"
#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

constexpr PanoramaSize kLeftOutSize{8, 4};

TEST(LeftOutPixels, AreFoundByStationAndColumn) {
  const std::vector<std::int32_t> runs = {2, 7, 3, 4, 1, 3, 2, 4, 1, 3, 0, 1, 1, 0, 0, 4};
  const LeftOutPixels pixels(runs, kLeftOutSize, 4, "a.h5");
  EXPECT_FALSE(pixels.any(0));
  EXPECT_TRUE(pixels.any(1));
  EXPECT_FALSE(pixels.any(3));
  EXPECT_THAT(pixels.rows(1, 0), ElementsAre(RowRun{0, 4}));
  EXPECT_THAT(pixels.rows(1, 1), IsEmpty());
  EXPECT_THAT(pixels.rows(1, 3), ElementsAre(RowRun{0, 1}, RowRun{2, 4}));
  EXPECT_THAT(pixels.rows(2, 7), ElementsAre(RowRun{3, 4}));
  EXPECT_THAT(pixels.rows(0, 7), IsEmpty());
}

TEST(LeftOutPixels, FollowASubsetOfTheStations) {
  const std::vector<std::int32_t> runs = {1, 0, 0, 4, 3, 5, 1, 2};
  const std::vector<int> kept = {0, 2, 3};
  const LeftOutPixels pixels = LeftOutPixels(runs, kLeftOutSize, 4, "a.h5").subset(kept);
  EXPECT_FALSE(pixels.any(0));
  EXPECT_FALSE(pixels.any(1));
  EXPECT_THAT(pixels.rows(2, 5), ElementsAre(RowRun{1, 2}));
}

TEST(LeftOutPixels, AreStoredForPanoramasOfAnotherSize) {
  const std::vector<std::int32_t> runs = {1, 3, 1, 3};
  const LeftOutPixels pixels(runs, kLeftOutSize, 4, "a.h5");
  EXPECT_EQ(pixels.stored_runs(kLeftOutSize), runs);
  EXPECT_THAT(pixels.stored_runs({4, 2}), ElementsAre(1, 1, 0, 2));
  EXPECT_THAT(pixels.stored_runs({16, 8}), ElementsAre(1, 6, 2, 6, 1, 7, 2, 6));
}

TEST(LeftOutPixels, RunsOutsideThePanoramaOrTheLineAreRefused) {
  const auto with = [](std::vector<std::int32_t> runs) {
    return [runs] { LeftOutPixels(runs, kLeftOutSize, 4, "a.h5"); };
  };
  const auto refused = ThrowsMessage<Error>(HasSubstr("a.h5: 'left_out'"));
  for (const std::vector<std::int32_t>& runs : std::vector<std::vector<std::int32_t>>{
           {4, 0, 0, 1}, {-1, 0, 0, 1}, {0, 8, 0, 1}, {0, 0, 2, 2}, {0, 0, 0, 5}, {0, 0, 0}}) {
    EXPECT_THAT(with(runs), refused);
  }
}

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

class DistanceSamplesTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, directory_ / "room.lf");
    return Room::open(directory_ / "room.lf");
  }

  TestDirectory directory_;
};

TEST_F(DistanceSamplesTest, WeightsAreSolidAngle) {
  const DistanceSamples known = sample_distances(room_of({.width = 64}), 1 << 20);
  EXPECT_NEAR(known.known_share, 1.0, 1e-6);
  double pixels = 0.0;
  for (const DistanceSample& sample : known.samples) pixels += sample.weight;
  // All maps have 64 x 32 pixels; their weights are the cosines of their rows, 2 / pi on average.
  EXPECT_NEAR(pixels / static_cast<double>(known.samples.size()), 2.0 / kPi, 1e-3);
}

TEST_F(DistanceSamplesTest, FewSamplesMatchTheFullStatistics) {
  const Room room = room_of({.width = 128});
  const std::array shares{0.05, 0.5, 0.95};
  DistanceSamples some = sample_distances(room, 500), all = sample_distances(room, 1 << 20);
  EXPECT_LT(10 * some.samples.size(), all.samples.size());
  const std::vector<double> few = distance_quantiles(some.samples, shares);
  const std::vector<double> many = distance_quantiles(all.samples, shares);
  for (size_t i = 0; i < shares.size(); ++i) EXPECT_NEAR(few[i], many[i], 0.05 * many[i]);
}

TEST(DistanceQuantiles, AreWeighted) {
  std::vector<DistanceSample> samples{{.distance_m = 3.0f, .weight = 1.0f},
                                      {.distance_m = 1.0f, .weight = 8.0f},
                                      {.distance_m = INFINITY, .weight = 1.0f}};
  EXPECT_THAT(distance_quantiles(samples, std::array{0.0, 0.5, 0.8, 0.85, 0.95, 1.0}),
              ElementsAre(1.0, 1.0, 1.0, 3.0, INFINITY, INFINITY));
}

TEST(DistanceQuantiles, ManyEqualDistancesAreOneQuantile) {
  std::vector<DistanceSample> samples(1000, {.distance_m = 2.5f, .weight = 0.25f});
  EXPECT_THAT(distance_quantiles(samples, std::array{0.01, 0.99}), ElementsAre(2.5, 2.5));
}

TEST_F(DistanceSamplesTest, RoomWithoutDistancesHasNoSamples) {
  DistanceSamples none = sample_distances(room_of({.width = 32, .distances = false}), 100);
  EXPECT_TRUE(none.samples.empty());
  EXPECT_EQ(none.known_share, 0.0);
  EXPECT_TRUE(std::isnan(distance_quantiles(none.samples, std::array{0.5})[0]));
}

}  // namespace
}  // namespace raywalk
