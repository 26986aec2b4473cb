#include "core/view/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/view/test_room.h"
#include "tests/synthetic_room/synthetic_scene.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

constexpr PanoramaSize kSize{256, 128};
const Vector3d kViewpoint(0.05, 0.0, -0.1);

class RingVisibilityTest : public testing::Test {
 protected:
  // A wall across the view, below the height of the cameras or hanging from the ceiling above it.
  enum class Wall { kNone, kLow, kHanging };
  static SyntheticRoomSpec spec(Wall wall) {
    SyntheticRoomSpec spec;
    spec.overhang_m = 0.25;
    spec.width = 32;
    spec.distance_width = kSize.width;
    if (wall == Wall::kLow) spec.scene.obstacle = SceneBox{{-0.9, -1.2, 0.8}, {0.9, -0.3, 0.9}};
    if (wall == Wall::kHanging) spec.scene.obstacle = SceneBox{{-0.9, 0.3, 0.8}, {0.9, 1.5, 0.9}};
    return spec;
  }
  explicit RingVisibilityTest(Wall wall = Wall::kLow) : room_(spec(wall)) {
    const std::vector<int> lines = {0, 1, 2, 3};
    distances_.compute(nearest_maps(room_.room(), lines, kViewpoint, 0.1, 2, 8), kViewpoint);
  }
  std::vector<std::uint8_t> visible(int theta, double d_p_m, double up_m = 0.0) {
    std::vector<std::uint8_t> rows;
    RingVisibility ring(kSize.height);
    ring.compute(distances_, theta, {static_cast<float>(d_p_m), static_cast<float>(up_m)}, rows);
    return rows;
  }
  bool distance_is_right(int u, int v) const {
    const Vector3d direction =
        direction_from_angles(angles_from_pixel({double(u), double(v)}, kSize));
    const double truth = distance_at(room_.spec().scene, kViewpoint, direction);
    return std::fabs(truth * distances_.column(u)[v] - 1.0) < 0.02;
  }
  // Whether an acquisition point d_p ahead of the viewpoint and `up` above it sees what the
  // viewpoint sees at (u, v).
  bool truly_visible(int u, int v, double d_p_m, double up_m) const {
    const SyntheticScene& scene = room_.spec().scene;
    const SphereAngles angles = angles_from_pixel({double(u), double(v)}, kSize);
    const Vector3d direction = direction_from_angles(angles);
    const Vector3d ahead(std::sin(angles.theta_rad), 0.0, std::cos(angles.theta_rad));
    const Vector3d from = kViewpoint + d_p_m * ahead + Vector3d(0.0, up_m, 0.0);
    const Vector3d ray = kViewpoint + distance_at(scene, kViewpoint, direction) * direction - from;
    return distance_at(scene, from, ray.normalized()) > 0.99 * ray.norm();
  }

  TestRoom room_;
  DistanceView distances_{room_.room()};
};

// From above a low wall hides little, from below a hanging one.
class LineHeights : public RingVisibilityTest, public testing::WithParamInterface<double> {
 protected:
  LineHeights() : RingVisibilityTest(GetParam() > 0.0 ? Wall::kHanging : Wall::kLow) {}
};
// As high as the viewpoint, then above and below it.
INSTANTIATE_TEST_SUITE_P(Metres, LineHeights, testing::Values(0.0, 0.05, 0.4, 0.7, -0.05, -0.4));

TEST_P(LineHeights, AgreesWithTheRoomInFrontAndBehind) {
  const double up_m = GetParam();
  int hidden = 0;
  int missed = 0;        // hidden, and taken for visible
  int overcautious = 0;  // visible, and taken for hidden: rows beside an edge may be
  int all = 0;
  // The second lies straight above or below the viewpoint.
  for (const double d_p_m : {0.4, 0.0, 0.65, -0.3, -0.7}) {
    for (int u = 0; u < kSize.width; ++u) {
      const auto rows = visible(u, d_p_m, up_m);
      ASSERT_EQ(rows.size(), static_cast<size_t>(kSize.height));
      for (int v = 0; v < kSize.height; ++v) {
        if (!distance_is_right(u, v)) continue;  // skips errors of the distance view at edges
        const bool sees = truly_visible(u, v, d_p_m, up_m);
        const bool said = rows[static_cast<size_t>(v)] != 0;
        hidden += sees ? 0 : 1;
        missed += said && !sees ? 1 : 0;
        overcautious += sees && !said ? 1 : 0;
        ++all;
      }
    }
  }
  EXPECT_GT(hidden, 100) << "the scene must hide something";
  EXPECT_LT(missed, hidden / 10);
  EXPECT_LT(overcautious, all / 100);
}

TEST_F(RingVisibilityTest, ALineThroughTheViewpointSeesAllButEdgeRows) {
  const float same_surface = 1.0f + distances_.surface_tolerance();
  int seen = 0;
  for (int u = 0; u < kSize.width; ++u) {
    const auto rows = visible(u, 0.0);
    const float* omega = distances_.column(u);
    for (int v = 1; v + 1 < kSize.height; ++v) {
      const bool beside_edge = std::max(omega[v - 1], omega[v + 1]) > omega[v] * same_surface;
      EXPECT_TRUE(rows[static_cast<size_t>(v)] != 0 || beside_edge) << u << ' ' << v;
      seen += rows[static_cast<size_t>(v)] != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(seen, kSize.width * kSize.height / 2);
}

class EmptyRoomVisibility : public RingVisibilityTest {
 protected:
  EmptyRoomVisibility() : RingVisibilityTest(Wall::kNone) {}
};

TEST_F(EmptyRoomVisibility, NothingIsHiddenInAConvexRoom) {
  for (const double d_p_m : {-0.7, -0.2, 0.2, 0.7}) {
    for (int u = 0; u < kSize.width; ++u) {
      EXPECT_EQ(visible(u, d_p_m), std::vector<std::uint8_t>(kSize.height, 1)) << u << ' ' << d_p_m;
    }
  }
}

// A line nearer to the floor or the ceiling sees more of it so obliquely that neighbouring rows
// differ by more than the tolerance.
TEST_F(EmptyRoomVisibility, HardlyAnythingIsHiddenFromLinesAboveAndBelow) {
  for (const double d_p_m : {-0.7, -0.2, 0.0, 0.2, 0.7}) {
    for (const double up_m : {0.3, -0.3}) {
      std::ptrdiff_t hidden = 0;
      for (int u = 0; u < kSize.width; ++u)
        hidden += std::ranges::count(visible(u, d_p_m, up_m), 0);
      EXPECT_LT(hidden, kSize.width * kSize.height / 200) << d_p_m << ' ' << up_m;
    }
  }
}

}  // namespace
}  // namespace raywalk
