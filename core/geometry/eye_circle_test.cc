#include "core/geometry/eye_circle.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raywalk {
namespace {

TEST(EyeCircle, TheLeftEyeStandsToTheLeftOfItsColumn) {
  const EyeCircle left{{1.0, 2.0, 3.0}, 0.1};
  // Ahead is +z, so that left is -x; then ahead is +x, so that left is +z.
  EXPECT_LT((left.position_m(0.0) - Eigen::Vector3d(0.9, 2.0, 3.0)).norm(), 1e-15);
  EXPECT_LT((left.position_m(kHalfPi) - Eigen::Vector3d(1.0, 2.0, 3.1)).norm(), 1e-15);
  EXPECT_LT((left.opposite().position_m(0.0) - Eigen::Vector3d(1.1, 2.0, 3.0)).norm(), 1e-15);
}

TEST(EyeCircle, FindsTheDirectionThatAPointIsSeenIn) {
  for (const double radius_m : {0.03, -0.03, 0.5, -0.5, 1e-9, 0.0}) {
    const EyeCircle eye{{0.2, 1.0, -0.3}, radius_m};
    for (double theta = -3.1; theta < 3.1; theta += 0.31) {
      for (const double phi : {-1.57, -1.0, 0.0, 0.7, 1.57}) {
        for (const double distance_m : {0.01, 1.0, 1e6}) {
          const Eigen::Vector3d point_m =
              eye.position_m(theta) + distance_m * direction_from_angles({theta, phi});
          const auto seen = eye.direction_of(point_m - eye.centre_m);
          ASSERT_TRUE(seen) << radius_m << ' ' << theta << ' ' << phi;
          // Across the ray; a point 0.01 m away almost straight up touches the circle.
          const double plan_m = distance_m * std::cos(phi);
          const double slack_m = 1e-15 * distance_m + 2e-16 / std::max(plan_m, 1e-6);
          ASSERT_NEAR(wrap_angle(seen->theta_rad - theta) * plan_m, 0.0, 1e-12 + slack_m);
          ASSERT_NEAR(seen->phi_rad, phi, 1e-9);
        }
      }
    }
  }
}

TEST(EyeCircle, DoesNotSeeWhatIsInside) {
  const EyeCircle eye{{0, 0, 0}, 0.1};
  EXPECT_FALSE(eye.direction_of({0.05, -1.0, 0.05}));
  EXPECT_FALSE(eye.direction_of({0.0, 1.0, 0.0}));
  EXPECT_TRUE(eye.direction_of({0.1, -1.0, 0.05}));
}

}  // namespace
}  // namespace raywalk
