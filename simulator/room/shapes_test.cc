#include "simulator/room/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/geometry/sphere.h"
#include "simulator/room/embree_scene.h"
#include "simulator/room/furniture.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/plan_rectangle.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

// Divergence theorem: a closed surface with outward normals encloses 1/3 sum (p . n) A.
double enclosed_volume(const Facets& facets) {
  double volume = 0.0;
  for (const Facet& facet : facets.facets) {
    const auto& c = facet.corners;
    const double area =
        0.5 * ((c[1] - c[0]).cross(c[3] - c[0]).norm() + (c[1] - c[2]).cross(c[3] - c[2]).norm());
    volume += area * facet.normal.dot(c[0]) / 3.0;
  }
  return volume;
}

void expect_flat(const Facets& facets) {
  for (const Facet& facet : facets.facets) {
    EXPECT_NEAR(facet.normal.norm(), 1.0, 1e-9);
    for (const Vector3d& corner : facet.corners) {
      EXPECT_NEAR(facet.normal.dot(corner - facet.corners[0]), 0.0, 1e-9);
    }
  }
}

TEST(ShapesTest, BoxIsClosedWhereverItStands) {
  Facets facets;
  add_box({{3, -2, 5}, 0.7}, {-0.5, 0, -0.25}, {0.5, 2, 0.75}, 0, &facets);
  EXPECT_EQ(facets.facets.size(), 6U);
  EXPECT_NEAR(enclosed_volume(facets), 2.0, 1e-9);
  expect_flat(facets);
}

// A frustum over a regular 12-gon; the 12-gon of circumradius r has the area 3 r^2.
TEST(ShapesTest, RodIsAClosedFrustumInAnyDirection) {
  HashRandom random(2);
  for (int i = 0; i < 50; ++i) {
    Facets facets;
    const Vector3d axis =
        direction_from_angles({random.uniform(-kPi, kPi), random.uniform(-kHalfPi, kHalfPi)});
    add_rod({{1, 2, 3}, random.uniform(-3, 3)}, {{0, 0, 0}, 2.0 * axis, 0.1, 0.2}, 0, &facets);
    const double expected = 2.0 / 3.0 * 3.0 * (0.1 * 0.1 + 0.1 * 0.2 + 0.2 * 0.2);
    EXPECT_NEAR(enclosed_volume(facets), expected, 1e-9);
    expect_flat(facets);
  }
}

TEST(ShapesTest, GlobeIsClosedAndRound) {
  Facets facets;
  add_globe({1, 2, 3}, 0.5, 0.4, 0, &facets);
  const double ellipsoid = 4.0 / 3.0 * kPi * 0.5 * 0.5 * 0.4;
  EXPECT_NEAR(enclosed_volume(facets), ellipsoid, 0.02 * ellipsoid);
  expect_flat(facets);
}

TEST(ShapesTest, FurnitureFitsItsDeclaredSize) {
  using Add = void (*)(const Placement&, HashRandom, Facets*);
  struct Case {
    Piece piece;
    Add add;
  };
  const auto shelf = [](const Placement& place, HashRandom random, Facets* facets) {
    add_shelf(place, shelf_piece(2.5).top, random, facets);
  };
  for (const Case& one : std::initializer_list<Case>{{chair_piece(), add_chair},
                                                     {table_piece(), add_table},
                                                     {sofa_piece(), add_sofa},
                                                     {shelf_piece(2.5), shelf},
                                                     {plant_piece(), add_plant},
                                                     {coat_stand_piece(), add_coat_stand}}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      Facets facets;
      one.add({}, HashRandom(seed), &facets);
      for (const Facet& facet : facets.facets) {
        for (const Vector3d& corner : facet.corners) {
          EXPECT_LE(std::abs(corner.x()), 0.5 * one.piece.size.x() + 0.03) << one.piece.name;
          EXPECT_LE(std::abs(corner.z()), 0.5 * one.piece.size.y() + 0.03) << one.piece.name;
          EXPECT_GE(corner.y(), -0.002) << one.piece.name;
          EXPECT_LE(corner.y(), one.piece.top) << one.piece.name;
        }
      }
    }
  }
}

TEST(EmbreeSceneTest, FindsTheNearestFacetAndItsExactDistance) {
  Facets facets;
  add_box({}, {-1, -1, 2}, {1, 1, 3}, 0, &facets);
  add_box({}, {-1, -1, 5}, {1, 1, 6}, 0, &facets);
  const EmbreeScene scene(facets.facets);
  const Vector3d direction = Vector3d(0.1, -0.2, 1.0).normalized();
  const Hit hit = scene.intersect(Ray{{0, 0, 0}, direction});
  ASSERT_GE(hit.facet, 0);
  EXPECT_NEAR(hit.distance, 2.0 / direction.z(), 1e-14);
  EXPECT_LT(scene.intersect(Ray{{0, 0, 0}, {0, 0, -1}}).facet, 0);
  EXPECT_TRUE(scene.occluded({{0, 0, 0}, {0, 0, 1}}, 2.1));
  EXPECT_FALSE(scene.occluded({{0, 0, 0}, {0, 0, 1}}, 1.9));
  // Batches of any size give the same results as single rays.
  std::vector<Ray> rays(21);
  for (int i = 0; i < 21; ++i) {
    rays[static_cast<std::size_t>(i)].direction =
        Vector3d(0.097 * (i - 10), 0.03 * i, 1.0).normalized();
  }
  std::vector<Hit> hits(rays.size());
  scene.intersect(rays, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Hit alone = scene.intersect(rays[i]);
    EXPECT_EQ(hits[i].facet, alone.facet) << i;
    EXPECT_EQ(hits[i].distance, alone.distance) << i;
  }
}

TEST(PlanRectangleTest, OverlapIsDetectedAtAnyRotation) {
  const PlanRectangle a{{0, 0}, {1, 0.5}, 0.0};
  EXPECT_TRUE(overlap(a, {{1.4, 0}, {0.5, 0.5}, 0.0}));
  EXPECT_FALSE(overlap(a, {{1.6, 0}, {0.5, 0.5}, 0.0}));
  // Rotated by 45 degrees, a square of half side 0.5 extends to 0.707.
  EXPECT_TRUE(overlap(a, {{1.69, 0}, {0.5, 0.5}, kPi / 4}));
  EXPECT_FALSE(overlap(a, {{1.72, 0}, {0.5, 0.5}, kPi / 4}));
  // The bounding boxes overlap, but not the rectangles.
  EXPECT_FALSE(overlap(a, {{1.6, 1.1}, {0.9, 0.2}, kPi / 4}));
  EXPECT_TRUE(inside({{0, 0}, {0.5, 0.5}, kPi / 4}, {-0.71, -0.71}, {0.71, 0.71}));
  EXPECT_FALSE(inside({{0, 0}, {0.5, 0.5}, kPi / 4}, {-0.70, -0.71}, {0.71, 0.71}));
}

// A yaw of 90 degrees rotates +z to +x, as for cameras.
TEST(PlacementTest, RotatesAsAttitudesDo) {
  const Placement place{{1, 0, 2}, kHalfPi};
  EXPECT_LT((place.point({0, 0, 1}) - Vector3d(2, 0, 2)).norm(), 1e-12);
}

}  // namespace
}  // namespace raywalk::capture
