#include "core/view/distance_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/view/map_lookup.h"
#include "core/view/test_room.h"
#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

// A pillar beyond the front right corner, or none.
SyntheticRoomSpec spec_with(bool pillar) {
  SyntheticRoomSpec spec = box_room(32);
  spec.distance_width = 128;
  spec.spacing_m = 0.25;
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
      const double omega = view.column(u)[v];
      good += std::fabs(1.0 / omega - truth) <= tolerance * truth ? 1 : 0;
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

// Of what a view sees, by both ways of looking a point up in a map.
TEST(LookUp, TellsSeenFromHiddenPoints) {
  const TestRoom& room = room_with(true);
  const Vector3d viewpoint(0.0, 0.0, 0.0);
  const SyntheticScene& scene = room.spec().scene;
  // A map at a corner of the grid, where the pillar hides other parts.
  const auto maps = nearest_maps(room.room(), kAllLines, {0.75, 0.0, 0.5}, 0.0, 1, 1);
  ASSERT_EQ(maps.size(), 1U);
  const SurfaceMap surfaces(room.room().distances(maps[0].line), maps[0].map);
  int wrong = 0, wrongly_held = 0, hidden = 0;
  for (int u = 0; u < 128; ++u) {
    for (int v = 2; v < 62; ++v) {
      const SphereAngles angles = angles_from_pixel({double(u), double(v)}, {128, 64});
      const Vector3d direction = direction_from_angles(angles);
      const double rho = distance_at(scene, viewpoint, direction);
      const auto inverse = static_cast<float>(1.0 / rho);
      const Vector3d from_map = viewpoint + rho * direction - maps[0].position_m;
      const double first = distance_at(scene, maps[0].position_m, from_map.normalized());
      const bool sees = first > 0.99 * from_map.norm();
      hidden += sees ? 0 : 1;
      const MapLookup found =
          look_up(room.room(), maps[0], direction.cast<float>(), inverse, viewpoint, 0.1f);
      EXPECT_NEAR(found.omega_there * from_map.norm(), 1.0, 1e-4);
      wrong += sees != (found.omega_map <= found.omega_there * 1.1f) ? 1 : 0;
      const HeldPoint held =
          look_up_point({surfaces, maps[0].position_m, viewpoint, angles.theta_rad},
                        static_cast<float>(std::sin(angles.phi_rad)),
                        static_cast<float>(std::cos(angles.phi_rad)), inverse, 0.1f);
      wrongly_held += sees != (held.part > 0.5f) ? 1 : 0;
      EXPECT_TRUE(held.part == 0.0f || std::fabs(held.inverse * rho - 1.0) < 0.11);
    }
  }
  EXPECT_GT(hidden, 30) << "the scene must hide something";
  EXPECT_LT(wrong, 0.01 * 128 * 60);
  EXPECT_LT(wrongly_held, 0.01 * 128 * 60);
}

}  // namespace
}  // namespace raywalk
