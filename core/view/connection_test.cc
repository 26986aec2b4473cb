#include "core/view/connection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

constexpr double kPlentyM = 1e9;  // an overhang that never runs out

double deg(double rad) { return degrees_from_radians(rad); }
ConnectionRule connection_rule(double k_deg, double overlap_deg = 5.0) {
  return {radians_from_degrees(k_deg), radians_from_degrees(overlap_deg)};
}
CornerView corner_at(double a, double b, double overhang = kPlentyM) {
  return {a, b, overhang, overhang};
}
double corner_angle(const CornerView& c) { return std::atan2(c.to_next_side_m, c.to_this_side_m); }

// Corners with all four lengths log-uniform over 1e-9..1e6, now and then exactly 0.
class RandomCorners {
 public:
  CornerView next() { return {length(), length(), length(), length()}; }
  double angle_deg(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

 private:
  double length() {
    if (std::uniform_int_distribution<int>(0, 15)(random_) == 0) return 0.0;
    return std::pow(10.0, std::uniform_real_distribution<double>(-9.0, 6.0)(random_));
  }
  std::mt19937_64 random_{7};
};

TEST(Connection, CutIsTheCornerAngleClampedToTheAllowedIncidence) {
  // k = 70 allows 20..70 degrees.
  for (const auto& [corner_deg, cut_deg] : {std::pair{15.0, 20.0}, {45.0, 45.0}, {75.0, 70.0}}) {
    const double c = radians_from_degrees(corner_deg);
    const CornerView corner = corner_at(std::sin(c), std::cos(c));
    EXPECT_NEAR(deg(hybrid_cut(corner, radians_from_degrees(70.0))), cut_deg, 1e-12);
  }
}

TEST(Connection, LfuCutsAtTheDiagonalAndRaySpace360AtTheCornerWithoutOverhang) {
  RandomCorners corners;
  for (int i = 0; i < 2000; ++i) {
    CornerView corner = corners.next();
    const CornerConnection physical = connect_corner(corner, connection_rule(90.0));
    EXPECT_EQ(physical.cut_rad, corner_angle(corner));
    EXPECT_FALSE(physical.limited);
    corner.overhang_this_m = corner.overhang_next_m = kPlentyM;
    if (corner.to_this_side_m + corner.to_next_side_m > 1e3) continue;
    EXPECT_NEAR(deg(connect_corner(corner, connection_rule(45.0)).cut_rad), 45.0, 1e-4);
  }
}

TEST(Connection, SharedAnglesEndWhereEitherLineEnds) {
  // 1 m to the next side, 0.5 m to this one. This line reaches 0.25 m beyond the corner, seen at
  // atan(1.25 / 0.5); the next one 0.5 m, seen at atan(1 / (0.5 + 0.5)) = 45 degrees.
  const SharedAngles shared = shared_angles({1.0, 0.5, 0.25, 0.5});
  EXPECT_NEAR(deg(shared.begin_rad), 45.0, 1e-12);
  EXPECT_NEAR(shared.end_rad, std::atan(2.5), 1e-15);
}

TEST(Connection, CutMovesContinuouslyTowardsPhysicalAsTheOverhangRunsOut) {
  // Both sides of the diagonal: the next line's overhang limits c > k, this line's c < 90 - k.
  for (const auto& [a, b] : {std::pair{1.0, 0.2}, {0.2, 1.0}}) {
    double previous = hybrid_cut(corner_at(a, b), radians_from_degrees(50.0));
    bool was_limited = false;
    for (double overhang = 2.0; overhang >= 0.0; overhang -= 0.001) {
      const CornerConnection connection =
          connect_corner(corner_at(a, b, std::max(0.0, overhang)), connection_rule(50.0));
      const double c = corner_angle(corner_at(a, b));
      EXPECT_LE(std::fabs(connection.cut_rad - c), std::fabs(previous - c) + 1e-15);
      // |d cut / d overhang| <= 1 / hypot(a, b + o) < 1.
      EXPECT_LT(std::fabs(connection.cut_rad - previous), 0.001 + 1e-12) << overhang;
      EXPECT_TRUE(connection.limited || !was_limited) << "limits come and stay";
      was_limited = connection.limited;
      previous = connection.cut_rad;
    }
    EXPECT_TRUE(was_limited);
  }
}

TEST(ConnectionProperty, CutAndBlendStayWithinBothLines) {
  RandomCorners corners;
  for (int i = 0; i < 20000; ++i) {
    const CornerView corner = corners.next();
    const ConnectionRule rule =
        connection_rule(corners.angle_deg(45.0, 90.0), corners.angle_deg(0.0, 45.0));
    const SharedAngles shared = shared_angles(corner);
    const CornerConnection connection = connect_corner(corner, rule);
    ASSERT_GE(shared.begin_rad, 0.0);
    ASSERT_LE(shared.begin_rad, shared.end_rad);
    ASSERT_LE(shared.end_rad, kHalfPi);
    ASSERT_GE(connection.blend_begin_rad, shared.begin_rad);
    ASSERT_LE(connection.blend_begin_rad, connection.cut_rad);
    ASSERT_LE(connection.cut_rad, connection.blend_end_rad);
    ASSERT_LE(connection.blend_end_rad, shared.end_rad);
    const double wanted = hybrid_cut(corner, rule.k_rad);
    const bool readable = wanted >= shared.begin_rad && wanted <= shared.end_rad;
    ASSERT_EQ(connection.limited, !readable);
    if (readable) {
      ASSERT_EQ(connection.cut_rad, wanted);
    }
  }
}

}  // namespace
}  // namespace raywalk
