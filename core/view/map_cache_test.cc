#include "core/view/map_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/view/test_room.h"

namespace raywalk {
namespace {

std::vector<MapStation> places(std::initializer_list<std::pair<int, int>> lines_and_maps) {
  std::vector<MapStation> all;
  for (const auto& [line, map] : lines_and_maps) all.push_back({.line = line, .map = map});
  return all;
}

TEST(MapCache, InverseDistancesAreLimitedAndNegativeWhereUnknown) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(stored_omega(4.0f, 255), 0.25f);
  EXPECT_EQ(stored_omega(4.0f, kMinConfidence), 0.25f);
  EXPECT_LT(stored_omega(4.0f, kMinConfidence - 1), 0.0f);
  EXPECT_LT(stored_omega(0.0f, 255), 0.0f);
  EXPECT_EQ(stored_omega(kInfinity, 255), 0.0f);
  EXPECT_EQ(stored_omega(1e-42f, 255), 1e9f);
}

TEST(MapCache, MapsHoldTheVolumesInverseDistances) {
  SyntheticRoomSpec spec = pillar_spec(32);
  spec.stored_confidence = [](int u, int v) {
    return static_cast<std::uint8_t>((u + v) % 3 == 0 ? kMinConfidence - 1 : 255);
  };
  const TestRoom room(spec);
  MapCache<SurfaceMap> surfaces(room.room());
  MapCache<OccluderMap> occluders(room.room());
  const auto at = places({{2, 4}, {0, 0}, {2, 7}});
  const auto surface = surfaces.get(at);
  const auto occluder = occluders.get(at);
  ASSERT_EQ(surface.size(), at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    const DistanceVolume& volume = room.room().distances(at[i].line);
    const PanoramaSize size = volume.size();
    ASSERT_EQ(surface[i]->size, size);
    const auto index = [&](int u, int v) {
      return static_cast<std::size_t>(u % size.width * size.height + std::min(v, size.height - 1));
    };
    for (int u = 0; u < size.width; ++u) {
      for (int v = 0; v < size.height; ++v) {
        const float distance_m = volume.distance_column(at[i].map, u)[static_cast<std::size_t>(v)];
        const float held = surface[i]->inverse[index(u, v)];
        ASSERT_EQ(held, (u + v) % 3 == 0 ? -1.0f : 1.0f / distance_m);
        float nearest = held;
        for (const auto& [x, y] : {std::pair{u + 1, v}, {u, v + 1}, {u + 1, v + 1}}) {
          nearest = std::max(nearest, surface[i]->inverse[index(x, y)]);
        }
        ASSERT_EQ(occluder[i]->nearest[index(u, v)], nearest);
      }
    }
  }
}

// A map of which four are kept.
struct LargeMap {
  LargeMap(const DistanceVolume& /*volume*/, int /*map*/) {}
  std::size_t bytes() const { return MapCache<LargeMap>::kKeptBytes / 4; }
};

TEST(MapCache, MapsUsedLongestAgoAreForgottenButThoseOfOneViewAreAllKept) {
  const TestRoom room(box_room(32));
  MapCache<LargeMap> cache(room.room());
  const auto get = [&](int map) { return cache.get(places({{0, map}})).front(); };
  // Held, so that a map read again cannot have the same address.
  std::vector<std::shared_ptr<const LargeMap>> held;
  for (int map = 0; map < 4; ++map) held.push_back(get(map));
  for (int map = 0; map < 4; ++map) EXPECT_EQ(get(map), held[static_cast<std::size_t>(map)]);
  EXPECT_EQ(get(0), held[0]);
  held.push_back(get(4));
  for (const int map : {0, 2, 3, 4}) {
    EXPECT_EQ(get(map), held[static_cast<std::size_t>(map)]) << map;
  }
  EXPECT_NE(get(1), held[1]);
  const auto all = places({{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 0}, {1, 1}});
  const auto first = cache.get(all);
  EXPECT_EQ(cache.get(all), first);
}

}  // namespace
}  // namespace raywalk
