#include "render/web/station_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/view/test_room.h"

namespace raywalk::render {
namespace {

const Eigen::Vector3d& position_m(const Room& room, int line, int station) {
  return room.grid().station({line, station}).position_m;
}

double true_omega(const TestRoom& room, int line, int station, const OmegaMap& map, int theta,
                  int row) {
  return 1.0 / distance_at(room.spec().scene, position_m(room.room(), line, station),
                           direction_from_angles(
                               angles_from_pixel({double(theta), double(row)}, map.size())));
}

// Share of the pixels within 3 % of the truth.
double share_right(const TestRoom& room, int line, int station, const OmegaMap& map) {
  int right = 0;
  for (int theta = 0; theta < map.size().width; ++theta) {
    for (int row = 0; row < map.size().height; ++row) {
      const double truth = true_omega(room, line, station, map, theta, row);
      if (std::abs(map.at(theta, row) - truth) <= 0.03 * truth) ++right;
    }
  }
  return static_cast<double>(right) / static_cast<double>(map.values().size());
}

bool complete(const OmegaMap& map) {
  return std::ranges::all_of(map.values(),
                             [](float omega) { return std::isfinite(omega) && omega >= 0.0F; });
}

TEST(StationDistances, AreThoseOfTheStationsOwnMap) {
  const TestRoom room(box_room(64));
  const OmegaMap map = StationDistances(room.room(), 64).seen_from(1, 5);
  for (int theta = 0; theta < 64; ++theta) {
    for (int row = 0; row < 32; ++row) {
      const double truth = true_omega(room, 1, 5, map, theta, row);
      EXPECT_NEAR(map.at(theta, row), truth, 1e-6 * truth) << theta << ',' << row;
    }
  }
}

TEST(StationDistances, AreRightWithoutAnOwnMapAndAtOtherWidths) {
  SyntheticRoomSpec spec = box_room(128);
  spec.distance_every = 3;
  const TestRoom room(spec);
  for (const int width : {128, 64, 44}) {
    StationDistances distances(room.room(), width);
    for (const int station : {0, 1, 7, 12}) {
      const OmegaMap map = distances.seen_from(2, station);
      EXPECT_EQ(map.size().width, width);
      EXPECT_TRUE(complete(map));
      EXPECT_GT(share_right(room, 2, station, map), 0.93) << width << " at " << station;
    }
  }
}

TEST(StationDistances, DoNotMixSurfacesAtSilhouettes) {
  SyntheticRoomSpec spec = box_room(256);
  spec.scene.obstacle = SceneBox{{-0.15, -1.2, -0.15}, {0.15, 0.6, 0.15}};
  const TestRoom room(spec);
  const OmegaMap map = StationDistances(room.room(), 64).seen_from(0, 6);
  // In the middle row the obstacle is 0.35 m away or more than 0.7 m nearer than any wall.
  for (int theta = 0; theta < 64; ++theta) {
    const float omega = map.at(theta, 16);
    EXPECT_TRUE(omega > 1.8F || omega < 0.65F) << theta << ": " << 1.0F / omega << " m";
  }
}

TEST(StationDistances, FillWhatTheMapsDoNotKnowAsViewsDo) {
  SyntheticRoomSpec spec = box_room(64);
  // Nothing is known of a part of the walls and of the zenith, from anywhere.
  spec.stored_confidence = [](int u, int v) -> std::uint8_t {
    return v < 6 || (u > 20 && u < 40 && v > 10 && v < 20) ? 0 : 255;
  };
  const TestRoom room(spec);
  const OmegaMap map = StationDistances(room.room(), 64).seen_from(3, 6);
  EXPECT_TRUE(complete(map));
  EXPECT_GT(share_right(room, 3, 6, map), 0.6) << "of the 73 % that are known, most";

  DistanceView view(room.room());
  const Eigen::Vector3d& at_m = position_m(room.room(), 3, 6);
  const MapSpread spread = map_spread(room.room().grid(), {at_m.x(), at_m.z()});
  const std::vector<int> lines{0, 1, 2, 3};
  view.compute(nearest_maps(room.room(), lines, at_m, spread.gap_m, spread.most_per_line,
                            ViewOptions().distance_maps),
               at_m);
  EXPECT_EQ(map.at(30, 15), view.column(30)[15]);
  EXPECT_EQ(map.at(3, 2), view.column(3)[2]);
  EXPECT_GT(map.at(30, 15), 0.0F);
}

TEST(StationDistances, AreIgnoredBelowTheConfidenceOfViews) {
  SyntheticRoomSpec spec = box_room(64);
  spec.stored_distance = [](int u, int v, double exact_m) {
    return static_cast<float>(u == 10 && v == 16 ? 0.01 : exact_m);
  };
  spec.stored_confidence = [](int u, int v) -> std::uint8_t {
    return u == 10 && v == 16 ? kMinConfidence - 1 : 255;
  };
  const TestRoom room(spec);
  EXPECT_LT(StationDistances(room.room(), 64).seen_from(0, 6).at(10, 16), 2.0F);
}

}  // namespace
}  // namespace raywalk::render
