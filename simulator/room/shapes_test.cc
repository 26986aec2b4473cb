#include "simulator/room/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/geometry/sphere.h"
#include "simulator/room/embree_scene.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;

// Divergence theorem: a closed surface with outward normals encloses 1/3 sum (p . n) A.
double enclosed_volume(const std::vector<Facet>& facets) {
  double volume = 0.0;
  for (const Facet& facet : facets) {
    const auto& c = facet.corners;
    const double area =
        0.5 * ((c[1] - c[0]).cross(c[3] - c[0]).norm() + (c[1] - c[2]).cross(c[3] - c[2]).norm());
    volume += area * facet.normal.dot(c[0]) / 3.0;
  }
  return volume;
}

void expect_flat(const std::vector<Facet>& facets) {
  for (const Facet& facet : facets) {
    EXPECT_NEAR(facet.normal.norm(), 1.0, 1e-9);
    for (const Vector3d& corner : facet.corners) {
      EXPECT_NEAR(facet.normal.dot(corner - facet.corners[0]), 0.0, 1e-9);
    }
  }
}

TEST(ShapesTest, BoxIsClosedWhereverItStands) {
  std::vector<Facet> facets;
  add_box({{3, -2, 5}, 0.7}, {-0.5, 0, -0.25}, {0.5, 2, 0.75}, 0, &facets);
  EXPECT_EQ(facets.size(), 6U);
  EXPECT_NEAR(enclosed_volume(facets), 2.0, 1e-9);
  expect_flat(facets);
}

// A frustum over a regular 12-gon; the 12-gon of circumradius r has the area 3 r^2.
TEST(ShapesTest, RodIsAClosedFrustumInAnyDirection) {
  HashRandom random(2);
  for (int i = 0; i < 50; ++i) {
    std::vector<Facet> facets;
    const Vector3d axis =
        direction_from_angles({random.uniform(-kPi, kPi), random.uniform(-kHalfPi, kHalfPi)});
    add_rod({{1, 2, 3}, random.uniform(-3, 3)}, {{0, 0, 0}, 2.0 * axis, 0.1, 0.2}, 0, &facets);
    const double expected = 2.0 / 3.0 * 3.0 * (0.1 * 0.1 + 0.1 * 0.2 + 0.2 * 0.2);
    EXPECT_NEAR(enclosed_volume(facets), expected, 1e-9);
    expect_flat(facets);
  }
}

TEST(ShapesTest, GlobeIsClosedAndRound) {
  std::vector<Facet> facets;
  add_globe({1, 2, 3}, 0.5, 0.4, 0, &facets);
  const double ellipsoid = 4.0 / 3.0 * kPi * 0.5 * 0.5 * 0.4;
  EXPECT_NEAR(enclosed_volume(facets), ellipsoid, 0.02 * ellipsoid);
  expect_flat(facets);
}

// Seen from the front, s runs to the right and t upwards.
TEST(ShapesTest, PanelsFaceTheRoomWithUprightTextures) {
  std::vector<Facet> facets;
  add_panel({{0, 0, 2}, kPi}, {-1, 0, 0}, {1, 1, 0.1}, 0, &facets);  // faces -z
  EXPECT_EQ(facets.size(), 5U) << "no back";
  expect_flat(facets);
  const Facet& front = facets.front();
  EXPECT_LT((front.normal - Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_LT((front.texture.s_axis - Vector3d(1, 0, 0)).norm(), 1e-12);
  const auto& c = front.corners;
  const Facet quad = make_quad({c[0], c[1], c[2], c[3]}, 0);
  EXPECT_LT((quad.normal - front.normal).norm(), 1e-12);
  EXPECT_LT((quad.texture.t_axis - front.texture.t_axis).norm(), 1e-12);
}

TEST(EmbreeSceneTest, FindsTheNearestFacetAndItsExactDistance) {
  std::vector<Facet> facets;
  add_box({}, {-1, -1, 2}, {1, 1, 3}, 0, &facets);
  add_box({}, {-1, -1, 5}, {1, 1, 6}, 0, &facets);
  const EmbreeScene scene(facets);
  const Vector3d direction = Vector3d(0.1, -0.2, 1.0).normalized();
  const Hit hit = scene.intersect(Ray{{0, 0, 0}, direction});
  ASSERT_GE(hit.facet, 0);
  EXPECT_NEAR(hit.distance, 2.0 / direction.z(), 1e-14);
  EXPECT_LT(scene.intersect(Ray{{0, 0, 0}, {0, 0, -1}}).facet, 0);
  EXPECT_TRUE(scene.occluded({{0, 0, 0}, {0, 0, 1}}, 2.1));
  EXPECT_FALSE(scene.occluded({{0, 0, 0}, {0, 0, 1}}, 1.9));
}

// A yaw of 90 degrees rotates +z to +x, as for cameras.
TEST(PlacementTest, RotatesAsAttitudesDo) {
  const Placement place{{1, 0, 2}, kHalfPi};
  EXPECT_LT((place.point({0, 0, 1}) - Vector3d(2, 0, 2)).norm(), 1e-12);
}

}  // namespace
}  // namespace raywalk::simulator
