#include "core/view/distance_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/view/test_room.h"
#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

SyntheticRoomSpec spec_with(bool pillar) {
  SyntheticRoomSpec spec;
  spec.overhang_m = 0.25;
  spec.width = 128;
  spec.spacing_m = 0.25;
  if (pillar) spec.scene.obstacle = SceneBox{{0.7, -1.2, 0.8}, {1.2, 0.3, 1.3}};
  return spec;
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
      const double omega = view.column(u)[v];
      good += std::fabs(1.0 / omega - truth) <= tolerance * truth ? 1 : 0;
    }
  }
  return static_cast<double>(good) / (size.width * size.height);
}

// Pixels along the edges of near surfaces.
struct Edges {
  int outside = 0;  // next to something nearer
  int grown = 0;    // of these, too near in the view
  int inside = 0;   // next to something farther
  int eaten = 0;    // of these, too far in the view

  Edges& operator+=(const Edges& other) {
    outside += other.outside;
    grown += other.grown;
    inside += other.inside;
    eaten += other.eaten;
    return *this;
  }
};

Edges edges_of(const DistanceView& view, const SyntheticScene& scene, const Vector3d& at) {
  const PanoramaSize size = view.size();
  const auto truth = [&](int u, int v) {
    const double column = (u + size.width) % size.width;
    return 1.0 / distance_at(scene, at,
                             direction_from_angles(angles_from_pixel({column, double(v)}, size)));
  };
  Edges edges;
  for (int u = 0; u < size.width; ++u) {
    for (int v = 1; v + 1 < size.height; ++v) {
      const double here = truth(u, v);
      const double around[] = {truth(u - 1, v), truth(u + 1, v), truth(u, v - 1), truth(u, v + 1)};
      const double held = view.column(u)[v];
      if (*std::max_element(around, around + 4) > 1.2 * here) {
        ++edges.outside;
        edges.grown += held > 1.1 * here ? 1 : 0;
      } else if (*std::min_element(around, around + 4) < here / 1.2) {
        ++edges.inside;
        edges.eaten += held < here / 1.1 ? 1 : 0;
      }
    }
  }
  return edges;
}

class DistanceViewAt : public testing::TestWithParam<PlanPoint> {
 protected:
  void look_around(const SyntheticRoomSpec& spec) {
    const TestRoom room(spec);
    const Vector3d at(GetParam().x_m, 0.0, GetParam().z_m);
    DistanceView view(room.room());
    view.compute(nearest_maps(room.room(), kAllLines, at, 0.1, 2, 8), at);
    unseen_share_ = view.unseen_share();
    share_right_ = share_within(view, spec.scene, at, 0.02);
  }
  double unseen_share_ = 1.0;
  double share_right_ = 0.0;  // of the pixels, within 2 % of the true distance
};

TEST_P(DistanceViewAt, MatchesTheRoomWhereEverythingIsSeen) {
  look_around(spec_with(false));
  EXPECT_EQ(unseen_share_, 0.0);
  EXPECT_GT(share_right_, 0.99);
}

TEST_P(DistanceViewAt, MatchesTheRoomWithAPillarButForItsEdges) {
  look_around(spec_with(true));
  EXPECT_LT(unseen_share_, 0.02);
  EXPECT_GT(share_right_, 0.97);
}

INSTANTIATE_TEST_SUITE_P(Viewpoints, DistanceViewAt,
                         testing::Values(PlanPoint{0.0, 0.0}, PlanPoint{0.31, -0.2},
                                         PlanPoint{0.5, 0.5}, PlanPoint{-0.25, 0.5}));

// A view takes the nearest of several maps, and the footprint of each of their pixels is rounded to
// whole pixels: edges move outwards by less than half a pixel on average, and no background shows
// through.
TEST(DistanceView, EdgesOfNearSurfacesMoveByLessThanHalfAPixel) {
  SyntheticRoomSpec spec = spec_with(true);
  spec.width = 256;
  const TestRoom room(spec);
  Edges edges;
  for (int i = 0; i < 40; ++i) {
    // Multiples of two irrational numbers spread evenly.
    const Vector3d at(std::fmod(0.618034 * i, 0.9) - 0.45, 0.0,
                      std::fmod(0.414214 * i, 0.9) - 0.45);
    DistanceView view(room.room());
    view.compute(nearest_maps(room.room(), kAllLines, at, 0.125, 2, 4), at);
    edges += edges_of(view, spec.scene, at);
  }
  ASSERT_GT(edges.outside, 1000);
  EXPECT_LT(edges.grown, 0.5 * edges.outside);
  EXPECT_LT(edges.eaten, 0.01 * edges.inside);
}

TEST(DistanceView, AtAMapItIsThatMap) {
  const TestRoom room(spec_with(true));
  const Vector3d at = room.room().grid().lines[1].stations[2].position_m;
  const auto maps = nearest_maps(room.room(), kAllLines, at, 0.1, 1, 1);
  ASSERT_EQ(maps.size(), 1U);
  DistanceView view(room.room());
  view.compute(maps, at);
  int different = 0;
  for (int u = 0; u < 128; ++u) {
    const auto map = room.room().distances(1).distance_column(2, u);
    for (size_t v = 0; v < map.size(); ++v) {
      // Nearest wins within a pixel's footprint: an edge may grow by a pixel, nothing else moves.
      different += std::fabs(view.column(u)[v] * map[v] - 1.0f) > 0.02f ? 1 : 0;
    }
  }
  EXPECT_LT(different, 0.01 * 128 * 64);
}

// A single wrong pixel at the rim of a gap is the farther one to fill its column with; the columns
// beside it tell otherwise.
TEST(DistanceView, AWrongPixelBesideAGapIsNoStreak) {
  constexpr int kRim = 39, kEnd = 56, kColumn = 30;
  SyntheticRoomSpec spec = spec_with(false);
  spec.stored_distance = [](int u, int v, double metres) {
    return static_cast<float>(u == kColumn && v == kRim ? 100.0 : metres);
  };
  spec.stored_confidence = [](int, int v) {
    return static_cast<std::uint8_t>(v > kRim && v < kEnd ? 0 : 255);
  };
  const TestRoom room(spec);
  const Vector3d at = room.room().grid().lines[1].stations[2].position_m;
  DistanceView view(room.room());
  view.compute(nearest_maps(room.room(), kAllLines, at, 0.1, 1, 1), at);
  for (int v = kRim + 1; v < kEnd; ++v) {
    const float beside = view.column(kColumn - 1)[v];
    EXPECT_NEAR(view.column(kColumn)[v], beside, 0.1 * beside) << v;
  }
}

TEST(DistanceView, InfinitelyFarStaysInfinitelyFar) {
  SyntheticRoomSpec spec = spec_with(false);
  spec.scene.infinitely_far = true;
  const TestRoom room(spec);
  const Vector3d at(0.2, 0.0, 0.1);
  const auto maps = nearest_maps(room.room(), kAllLines, at, 0.1, 2, 8);
  DistanceView view(room.room());
  view.compute(maps, at);
  for (int u = 0; u < view.size().width; ++u) {
    EXPECT_EQ(*std::max_element(view.column(u), view.column(u) + view.size().height), 0.0f);
  }
}

TEST(DistanceView, ReuseForgetsThePreviousViewpoint) {
  const TestRoom room(spec_with(true));
  const Vector3d at(0.2, 0.0, 0.1);
  const auto maps = nearest_maps(room.room(), kAllLines, at, 0.1, 2, 8);
  DistanceView fresh(room.room()), reused(room.room());
  fresh.compute(maps, at);
  reused.compute(maps, {-0.4, 0.0, -0.4});
  reused.compute(maps, at);
  for (int u = 0; u < fresh.size().width; ++u) {
    for (int v = 0; v < fresh.size().height; ++v) {
      ASSERT_EQ(fresh.column(u)[v], reused.column(u)[v]);
    }
  }
}

TEST(OmegaRange, HoldsTheNearestAndTheFarthestPointOfAMap) {
  const TestRoom room(spec_with(true));
  const auto maps = nearest_maps(room.room(), kAllLines, {0.3, 0.0, 0.2}, 0.1, 2, 1);
  double nearest_m = 1e9;
  double farthest_m = 0.0;
  for (int u = 0; u < 128; ++u) {
    for (const float metres : room.room().distances(maps[0].line).distance_column(maps[0].map, u)) {
      nearest_m = std::min(nearest_m, static_cast<double>(metres));
      farthest_m = std::max(farthest_m, static_cast<double>(metres));
    }
  }
  const OmegaRange range = omega_range(room.room(), maps[0]);
  EXPECT_NEAR(range.min, 1.0 / farthest_m, 1e-6);
  EXPECT_NEAR(range.max, 1.0 / nearest_m, 1e-6);
}

TEST(NearestMaps, AreSortedSpreadAndLimited) {
  const TestRoom room(spec_with(false));
  const Vector3d at(0.1, 0.0, 0.2);
  const auto distance = [&](const MapStation& map) { return (map.position_m - at).norm(); };
  const auto maps = nearest_maps(room.room(), kAllLines, at, 0.3, 3, 7);
  ASSERT_EQ(maps.size(), 7U);
  for (size_t i = 0; i < maps.size(); ++i) {
    EXPECT_GE(distance(maps[i]), distance(maps[i == 0 ? 0 : i - 1]));
    EXPECT_LE(std::count_if(maps.begin(), maps.end(),
                            [&](const MapStation& map) { return map.line == maps[i].line; }),
              3);
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GE((maps[i].position_m - maps[j].position_m).norm(), 0.3);
    }
    const Line& line = room.room().grid().lines[static_cast<size_t>(maps[i].line)];
    EXPECT_EQ(line.stations[static_cast<size_t>(maps[i].station)].position_m, maps[i].position_m);
  }
  // The nearest station is among them.
  double least = 1e9;
  for (const Line& line : room.room().grid().lines) {
    for (const Station& station : line.stations) {
      least = std::min(least, (station.position_m - at).norm());
    }
  }
  EXPECT_EQ(distance(maps.front()), least);
}

TEST(NearestMaps, ComeFromTheGivenLinesOnly) {
  const TestRoom room(spec_with(false));
  const auto maps = nearest_maps(room.room(), std::vector{2}, {0, 0, 0}, 0.0, 99, 99);
  EXPECT_FALSE(maps.empty());
  for (const MapStation& map : maps) EXPECT_EQ(map.line, 2);
}

TEST(LookUp, FindsSeenAndHiddenPoints) {
  const TestRoom room(spec_with(true));
  const Vector3d viewpoint(0.0, 0.0, 0.0);
  const SyntheticScene& scene = room.spec().scene;
  // A map at a corner of the grid, where the pillar hides other parts.
  const auto maps = nearest_maps(room.room(), kAllLines, {0.75, 0.0, 0.5}, 0.0, 1, 1);
  ASSERT_EQ(maps.size(), 1U);
  int wrong = 0;
  int hidden = 0;
  for (int u = 0; u < 128; ++u) {
    for (int v = 2; v < 62; ++v) {
      const Vector3d direction =
          direction_from_angles(angles_from_pixel({double(u), double(v)}, {128, 64}));
      const double rho = distance_at(scene, viewpoint, direction);
      const Vector3d from_map = viewpoint + rho * direction - maps[0].position_m;
      const MapLookup found = look_up(room.room(), maps[0], direction.cast<float>(),
                                      static_cast<float>(1.0 / rho), viewpoint, 0.1f);
      EXPECT_NEAR(found.omega_there * from_map.norm(), 1.0, 1e-4);
      const double first = distance_at(scene, maps[0].position_m, from_map.normalized());
      const bool sees = first > 0.99 * from_map.norm();
      const bool said = found.omega_map <= found.omega_there * 1.1f;
      hidden += sees ? 0 : 1;
      wrong += sees == said ? 0 : 1;
    }
  }
  EXPECT_GT(hidden, 30) << "the scene must hide something";
  EXPECT_LT(wrong, 0.01 * 128 * 60);
}

}  // namespace
}  // namespace raywalk
