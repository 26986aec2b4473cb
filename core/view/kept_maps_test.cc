#include "core/view/kept_maps.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

#include "core/view/test_points.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

using MapPlaces = std::vector<KeptMaps::Place>;
using MapPointers = std::vector<std::shared_ptr<const KeptMap>>;

TEST(KeptMaps, InverseDistancesAreLimitedAndNegativeWhereUnknown) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(stored_omega(4.0f, 255), 0.25f);
  EXPECT_EQ(stored_omega(4.0f, kMinConfidence), 0.25f);
  EXPECT_LT(stored_omega(4.0f, kMinConfidence - 1), 0.0f);
  EXPECT_LT(stored_omega(0.0f, 255), 0.0f);
  EXPECT_EQ(stored_omega(kInfinity, 255), 0.0f);
  EXPECT_EQ(stored_omega(1e-42f, 255), 1e9f);
}

TEST(KeptMaps, HoldTheVolumesInverseDistances) {
  SyntheticRoomSpec spec = pillar_spec();
  spec.stored_confidence = [](int u, int v) {
    return static_cast<std::uint8_t>((u + v) % 3 == 0 ? kMinConfidence - 1 : 255);
  };
  const TestRoom room(spec);
  KeptMaps kept(room.room());
  const MapPlaces places = {{2, 4}, {0, 0}, {2, 7}};
  const MapPointers maps = kept.get(places);
  ASSERT_EQ(maps.size(), places.size());
  for (size_t i = 0; i < maps.size(); ++i) {
    const DistanceVolume& volume = room.room().distances(places[i].line);
    ASSERT_EQ(maps[i]->size, volume.size());
    const auto rows = static_cast<size_t>(volume.size().height);
    for (int theta = 0; theta < volume.size().width; ++theta) {
      for (size_t row = 0; row < rows; ++row) {
        const float omega = maps[i]->omega[static_cast<size_t>(theta) * rows + row];
        const float distance_m = volume.distance_column(places[i].map, theta)[row];
        if ((static_cast<size_t>(theta) + row) % 3 == 0) {
          ASSERT_LT(omega, 0.0f);
        } else {
          ASSERT_FLOAT_EQ(omega, 1.0f / distance_m);
        }
      }
    }
  }
}

TEST(KeptMaps, AMapUsedBeforeIsTheSameObject) {
  const TestRoom& room = pillar_room();
  KeptMaps kept(room.room());
  const MapPointers first = kept.get(MapPlaces{{0, 1}, {1, 3}});
  const MapPointers second = kept.get(MapPlaces{{1, 3}, {3, 2}, {0, 1}});
  EXPECT_EQ(second[0], first[1]);
  EXPECT_EQ(second[2], first[0]);
  EXPECT_NE(second[1], first[0]);
  EXPECT_NE(second[1], first[1]);
  EXPECT_EQ(kept.get(MapPlaces{{3, 2}}).front(), second[1]);
}

// A single line with maps of an eighth of what is kept each.
SyntheticRoomSpec large_maps_spec() {
  SyntheticRoomSpec spec;
  spec.cells_z = 0;
  spec.width = 64;
  spec.distance_width = 2048;
  spec.stored_distance = [](int, int, double) { return 2.0f; };
  return spec;
}

const TestRoom& room_of_large_maps() {
  static const TestRoom room(large_maps_spec());
  return room;
}

TEST(KeptMaps, BeyondTheLimitTheMapUsedLongestAgoIsForgotten) {
  const TestRoom& room = room_of_large_maps();
  KeptMaps kept(room.room());
  const auto get = [&](int map) { return kept.get(MapPlaces{{0, map}}).front(); };
  MapPointers held;  // so that a map read again cannot have the same address
  for (int map = 0; map < 8; ++map) held.push_back(get(map));
  ASSERT_EQ(8 * held.front()->omega.size() * sizeof(float), KeptMaps::kKeptBytes);
  for (int map = 0; map < 8; ++map) EXPECT_EQ(get(map), held[static_cast<size_t>(map)]);
  EXPECT_EQ(get(0), held[0]);
  held.push_back(get(8));
  for (const int map : {0, 2, 3, 4, 5, 6, 7, 8}) {
    EXPECT_EQ(get(map), held[static_cast<size_t>(map)]) << map;
  }
  EXPECT_NE(get(1), held[1]);
}

TEST(KeptMaps, MapsOfOneViewAreAllKeptHoweverLarge) {
  const TestRoom& room = room_of_large_maps();
  KeptMaps kept(room.room());
  MapPlaces all;
  for (int map = 0; map < 9; ++map) all.push_back({0, map});
  const MapPointers first = kept.get(all);
  EXPECT_EQ(kept.get(all), first);
}

}  // namespace
}  // namespace raywalk
