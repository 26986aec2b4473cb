#include "calibrate/lens/lens_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/lens/lens_test_camera.h"

namespace raywalk::calibrate {
namespace {

using Eigen::Vector3d;

// Three stations with four features each: 0 and 1 of the front lens, 2 and 3 of the back lens.
std::vector<LensFeatures> three_stations() {
  std::vector<LensFeatures> stations(3);
  for (LensFeatures& station : stations) {
    for (int i = 0; i < 4; ++i) station.features.push_back({{10.0 * i, 5.0}, i >= 2});
  }
  return stations;
}

TEST(LensTracksTest, MatchesJoinAcrossStationsAndLenses) {
  const std::vector<LensFeatures> stations = three_stations();
  const std::vector<ViewMatches> matches{
      {0, 1, {{0, 1}}}, {1, 2, {{1, 0}, {2, 2}}}, {2, 2, {{0, 3}}}};
  const std::vector<BundleTrack> tracks = join_tracks(stations, matches);
  // The other one, feature 2 at stations 1 and 2, has two observations only.
  ASSERT_EQ(tracks.size(), 1U);
  EXPECT_EQ(tracks[0].size(), 4U);
}

TEST(LensTracksTest, InconsistentTracksAreDropped) {
  const std::vector<LensFeatures> stations = three_stations();
  EXPECT_TRUE(
      join_tracks(stations,
                  std::vector<ViewMatches>{{0, 1, {{0, 0}}}, {1, 2, {{0, 0}}}, {0, 2, {{1, 0}}}})
          .empty());
}

// A track of the front lens seen in a direction, moving that far between two stations and a third.
BundleTrack seen_at(const FisheyeLens& lens, const Vector3d& direction, double moves_px) {
  const PixelPosition at = *project(lens, direction);
  return {{0, false, at},
          {1, false, {at.u + 0.5 * moves_px, at.v}},
          {2, false, {at.u + moves_px, at.v}}};
}

TEST(LensTracksTest, OnlyStillTracksBelowTheCameraAreRemoved) {
  const DualFisheyeLayout layout = plain_camera({1120, 560}).layout;
  const std::vector<BundleStation> stations{{0, {0, 0, 0}}, {0, {0.1, 0, 0}}, {0, {0.2, 0, 0}}};
  const Vector3d down(0, -1, 0);
  const double cone_rad = radians_from_degrees(40.0);
  const auto removed = [&](const Vector3d& direction, double moves_px,
                           const std::vector<BundleStation>& seen_from) {
    std::vector<BundleTrack> tracks{seen_at(layout.front, direction, moves_px)};
    return remove_still_tracks(layout, seen_from, down, cone_rad, &tracks) == 1 && tracks.empty();
  };
  const Vector3d below = Vector3d(0.1, -1.0, 0.3).normalized();
  EXPECT_TRUE(removed(below, 0.3, stations));
  EXPECT_FALSE(removed(below, 5.0, stations));                             // the floor
  EXPECT_FALSE(removed(Vector3d(0, 0.2, 1).normalized(), 0.0, stations));  // the sky
  EXPECT_FALSE(removed(below, 0.3, std::vector<BundleStation>(3)));        // nothing moved
}

TEST(LensTracksTest, ThinningKeepsTracksOfBothLenses) {
  std::vector<BundleTrack> tracks;
  for (std::size_t i = 0; i < 1000; ++i) {
    tracks.push_back({{i, false, {}}, {i + 1, false, {}}, {i + 2, i % 10 == 0, {}}});
  }
  std::vector<BundleTrack> thinned = tracks;
  thin_tracks(300, &thinned);
  ASSERT_EQ(thinned.size(), 300U);
  int both = 0, first_half = 0;
  for (const BundleTrack& track : thinned) {
    both += track.back().back ? 1 : 0;
    first_half += track.front().station < 500 ? 1 : 0;
  }
  EXPECT_EQ(both, 100);
  EXPECT_NEAR(first_half, 150, 2);
  thin_tracks(5000, &tracks);
  EXPECT_EQ(tracks.size(), 1000U);
}

}  // namespace
}  // namespace raywalk::calibrate
