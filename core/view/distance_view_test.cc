#include "core/view/distance_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "core/view/map_cache.h"
#include "core/view/smooth_distances.h"
#include "core/view/test_room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

// A pillar beyond the front right corner, or none.
SyntheticRoomSpec spec_with(bool pillar) {
  SyntheticRoomSpec spec{.spacing_m = 0.25, .overhang_m = 0.25, .width = 32, .distance_width = 128};
  if (pillar) spec.scene.obstacle = SceneBox{{0.7, -1.2, 0.8}, {1.2, 0.3, 1.3}};
  return spec;
}
const TestRoom& room_with(bool pillar) {
  static const TestRoom with(spec_with(true)), without(spec_with(false));
  return pillar ? with : without;
}
const std::vector<int> kAllLines = {0, 1, 2, 3};

// Share of a view's pixels whose distance is within `tolerance` of the truth, relative to it.
double share_within(const DistanceView& view, const SyntheticScene& scene, const Vector3d& at,
                    double tolerance) {
  const PanoramaSize size = view.size();
  int good = 0;
  for (int u = 0; u < size.width; ++u) {
    for (int v = 0; v < size.height; ++v) {
      const double truth = distance_at(
          scene, at, direction_from_angles(angles_from_pixel({double(u), double(v)}, size)));
      const double inverse = view.column(u)[v];
      good += std::fabs(1.0 / inverse - truth) <= tolerance * truth ? 1 : 0;
    }
  }
  return static_cast<double>(good) / (size.width * size.height);
}

TEST(DistanceView, MatchesTheRoomButForTheEdgesOfAPillar) {
  for (const bool pillar : {false, true}) {
    const TestRoom& room = room_with(pillar);
    for (const PlanPoint p : {PlanPoint{0.0, 0.0}, {0.31, -0.2}, {0.5, 0.5}, {-0.25, 0.5}}) {
      const Vector3d at(p.x_m, 0.0, p.z_m);
      DistanceView view(room.room());
      view.compute(nearest_maps(room.room(), kAllLines, at, 0.1, 2, 8), at);
      EXPECT_LE(view.unseen_share(), pillar ? 0.02 : 0.0);
      EXPECT_GT(share_within(view, room.spec().scene, at, 0.02), pillar ? 0.97 : 0.99);
    }
  }
}

// Each pixel of a map shows one surface, half a pixel off at most: fewer than a quarter of the
// pixels along edges are on the other side.
TEST(DistanceView, EdgesOfNearSurfacesMoveByLessThanHalfAPixel) {
  SyntheticRoomSpec spec = spec_with(true);
  spec.distance_width = 256;
  const TestRoom room(spec);
  int edge = 0, wrong = 0;
  for (int i = 0; i < 20; ++i) {
    // Multiples of two irrational numbers spread evenly.
    const Vector3d at(std::fmod(0.618034 * i, 0.9) - 0.45, 0.0,
                      std::fmod(0.414214 * i, 0.9) - 0.45);
    DistanceView view(room.room());
    view.compute(nearest_maps(room.room(), kAllLines, at, 0.125, 2, 4), at);
    const auto truth = [&](int u, int v) {
      const SphereAngles angles = angles_from_pixel({double(u), double(v)}, view.size());
      return 1.0 / distance_at(spec.scene, at, direction_from_angles(angles));
    };
    for (int u = 0; u < view.size().width; ++u) {
      for (int v = 1; v + 1 < view.size().height; ++v) {
        const double here = truth(u, v);
        const auto [farthest, nearest] =
            std::minmax({truth(u - 1, v), truth(u + 1, v), truth(u, v - 1), truth(u, v + 1)});
        if (nearest < 1.2 * here && farthest > here / 1.2) continue;
        ++edge;
        wrong += std::fabs(view.column(u)[v] / here - 1.0) > 0.1 ? 1 : 0;
      }
    }
  }
  ASSERT_GT(edge, 1000);
  EXPECT_LT(wrong, 0.25 * edge);
}

// Rows that no map sees are what is behind: the farther of the surfaces above and below.
TEST(DistanceView, AGapIsFilledFromTheFartherSurface) {
  SyntheticRoomSpec spec = spec_with(false);
  spec.stored_distance = [](int, int v, double) { return v < 30 ? 1.0f : 3.0f; };
  spec.stored_confidence = [](int, int v) {
    return static_cast<std::uint8_t>(v > 28 && v < 32 ? 0 : 255);
  };
  const TestRoom room(spec);
  const Vector3d at = room.room().grid().lines[1].stations[2].position_m;
  DistanceView view(room.room());
  view.compute(nearest_maps(room.room(), kAllLines, at, 0.1, 1, 1), at);
  for (int v = 0; v < view.size().height; ++v) {
    EXPECT_NEAR(view.column(7)[v], v <= 28 ? 1.0 : 1.0 / 3, 1e-5) << v;
  }
  EXPECT_NEAR(view.unseen_share(), 3.0 / view.size().height, 1e-9);
}

TEST(NearestMaps, AreSortedSpreadAndLimited) {
  const TestRoom& room = room_with(false);
  const Vector3d at(0.1, 0.0, 0.2);
  const auto distance = [&](const MapStation& map) { return (map.position_m - at).norm(); };
  const auto maps = nearest_maps(room.room(), kAllLines, at, 0.3, 3, 7);
  ASSERT_EQ(maps.size(), 7U);
  EXPECT_NEAR(distance(maps.front()), std::hypot(0.1, 0.3), 1e-9) << "the nearest of all";
  for (std::size_t i = 0; i < maps.size(); ++i) {
    EXPECT_GE(distance(maps[i]), distance(maps[i == 0 ? 0 : i - 1]));
    EXPECT_LE(std::ranges::count(maps, maps[i].line, &MapStation::line), 3);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GE((maps[i].position_m - maps[j].position_m).norm(), 0.3);
    }
  }
  for (const MapStation& map : nearest_maps(room.room(), std::vector{2}, at, 0.0, 99, 99)) {
    EXPECT_EQ(map.line, 2);
  }
}

constexpr PanoramaSize kMapSize{256, 128};

// Trust in a map of the given confidences.
MapTrust trust_in(const std::function<std::uint8_t(int u, int v)>& confidence) {
  const TestRoom room({.spacing_m = 0.5,
                       .width = 16,
                       .distance_every = 100,
                       .distance_width = kMapSize.width,
                       .stored_confidence = confidence});
  return {room.room().distances(0), 0};
}

// In column `u`, at the horizon, of a view from the map's station.
float trust_at(const MapTrust& map, double u) {
  float trust = 0.0f, far = 0.0f;
  map.find_most(theta_of_column(u, kMapSize.width), Latitudes(1), {}, &far, &trust);
  return trust;
}

TEST(MapTrust, FallsSmoothlyToNothingWhereMostPixelsAreUnreliable) {
  const auto few = [](int u, int v) { return u % 4 == 0 && v % 4 == 0 ? 10 : 200; };
  EXPECT_TRUE(trust_in(few).everywhere()) << "a few change nothing";
  const MapTrust trust = trust_in([](int u, int) { return u < kMapSize.width / 2 ? 255 : 70; });
  EXPECT_FALSE(trust.everywhere());
  EXPECT_EQ(trust_at(trust, 64.0), 1.0f);
  EXPECT_LT(trust_at(trust, 192.0), 0.01f);
  for (int u = 0; u < kMapSize.width; ++u) {
    const float step = trust_at(trust, u) - trust_at(trust, u + 1.0);
    EXPECT_LT(std::fabs(step), 0.2f) << u;
  }
}

// In a view that is not to be relied on.
TEST(SmoothDistances, GapsTakeTheDistanceAroundAndAreFarWithoutAny) {
  const MapTrust trust = trust_in([](int, int) { return 64; });
  cv::Mat1f seen(kMapSize.width, kMapSize.height, 0.5f);
  const auto smoothed = [&](int theta) {
    SmoothDistances smooth;
    smooth.compute(std::span(seen[0], seen.total()), kMapSize, EyeCircle(),
                   std::vector<TrustedMap>{{.trust = &trust}});
    std::vector<float> column(128, 100.0f);
    EXPECT_NE(smooth.trust(theta), nullptr);
    smooth.smooth(theta, column);
    return column;
  };
  seen(cv::Range(0, 30), cv::Range(40, 100)) = -1.0f;
  seen(cv::Range(226, 256), cv::Range(40, 100)) = -1.0f;
  for (const int theta : {250, 0, 10}) {
    for (const float inverse : smoothed(theta)) EXPECT_NEAR(inverse, 0.5f, 1e-3f);
  }
  seen = -1.0f;
  for (const float inverse : smoothed(9)) EXPECT_EQ(inverse, 0.0f);
}

TEST(SmoothDistances, AreFiniteWhateverTheDistancesInViewsOfAnySize) {
  const MapTrust trust = trust_in([](int u, int) { return u % 3 == 0 ? 200 : 64; });
  const std::vector<TrustedMap> maps{{.trust = &trust, .position_m = {1.0, 2.0, 3.0}}};
  std::mt19937 random(3);
  for (const int height : {1, 2, 3, 5, 125}) {
    const auto rows = static_cast<size_t>(height);
    std::vector<float> inverse(2 * rows * rows);
    for (float& each : inverse) each = std::array{-1.0f, 0.0f, 1e-9f, 1e9f}[random() % 4];
    SmoothDistances smooth;
    smooth.compute(inverse, {2 * height, height}, EyeCircle(), maps);
    for (int theta = 0; theta < 2 * height; ++theta) {
      std::vector<float> column(rows, 1e9f);
      EXPECT_NE(smooth.trust(theta), nullptr);
      smooth.smooth(theta, column);
      for (const float each : column) EXPECT_TRUE(each >= 0.0f && each <= 1.001e9f) << height;
    }
  }
}

std::vector<MapStation> places(std::initializer_list<std::pair<int, int>> lines_and_maps) {
  std::vector<MapStation> all;
  for (const auto& [line, map] : lines_and_maps) all.push_back({.line = line, .map = map});
  return all;
}

TEST(MapCache, InverseDistancesAreLimitedAndNegativeWhereUnknown) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(stored_inverse(4.0f, 255), 0.25f);
  EXPECT_EQ(stored_inverse(4.0f, kMinConfidence), 0.25f);
  EXPECT_LT(stored_inverse(4.0f, kMinConfidence - 1), 0.0f);
  EXPECT_LT(stored_inverse(0.0f, 255), 0.0f);
  EXPECT_EQ(stored_inverse(kInfinity, 255), 0.0f);
  EXPECT_EQ(stored_inverse(1e-42f, 255), 1e9f);
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
