#include "core/room/distance_samples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::ElementsAre;

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
  // Half of the sphere lies above 0 degrees, a quarter above 30.
  double all = 0.0, above_30 = 0.0;
  for (const DistanceSample& sample : known.samples) {
    all += sample.weight;
    if (sample.phi_rad > radians_from_degrees(30.0)) above_30 += sample.weight;
  }
  EXPECT_NEAR(above_30 / all, 0.25, 0.02);
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
