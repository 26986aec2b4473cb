#include "calibrate/poses/crossing_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "calibrate/poses/pose_accuracy.h"
#include "calibrate/poses/test_rail_scene.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kNoise_px = 0.4;

struct CheckedGrid {
  CaptureSet set{};
  std::vector<LineCrossing> crossings{};
  FramePoses poses{};
  DividedPoints points{};

  explicit CheckedGrid(unsigned seed, double scale = 1.0) : set(test_grid(13, scale)) {
    crossings = crossings_of(set);
    poses = test_truth(set, {.line_m = 0.02 * scale, .jitter_m = 1e-3 * scale}, seed);
    points =
        divide_points(set, crossings, test_points(set, poses, 3000, scale, kNoise_px, seed + 100));
    for (auto& pose : poses) {
      pose->position_sigma_mm = 1e-3 * scale;
      pose->rotation_sigma_deg = 1e-4;
    }
  }
  void move(int line, const Eigen::Vector3d& by_m, const Eigen::Vector3d& turn_rad) {
    for (const int frame : set.lines[line].frames) {
      FramePose& pose = *poses[frame];
      pose.position_m = matrix_of(turn_rad) * pose.position_m + by_m;
      pose.world_from_camera = matrix_of(turn_rad) * pose.world_from_camera;
    }
  }
  std::vector<CrossingCheck> checks() const {
    return check_crossings(set, crossings, poses, kNoise_px, points.held_out);
  }
};

TEST(DividePoints, HoldsOutHalfOfThePointsThatConnectLines) {
  const CheckedGrid grid(1);
  const std::size_t held = grid.points.held_out.points_m.size();
  const std::size_t used = grid.points.used.points_m.size();
  EXPECT_EQ(held + used, 3000U);
  EXPECT_GT(held, 300U);
  EXPECT_LT(held, used);
}

// What the points ask for is within its own sigmas: the mean of the squares of three components
// over their variances is 1.
TEST(CheckCrossings, FindsNothingAtTrueAndItsSigmasAreRight) {
  double square = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const CheckedGrid grid(seed);
    for (const CrossingCheck& check : grid.checks()) {
      EXPECT_THAT(crossing_faults(grid.set, check, 0.125), IsEmpty()) << seed;
      const Eigen::Matrix3d position = check.covariance.topLeftCorner<3, 3>();
      square += check.motion_m.dot(position.inverse() * check.motion_m) / 3.0;
      ++count;
    }
  }
  EXPECT_EQ(count, 32);
  EXPECT_NEAR(square / count, 1.0, 0.35);
}

TEST(CheckCrossings, MeasuresHowALineDisagrees) {
  for (const double scale : {1e-2, 1.0, 1e2}) {
    CheckedGrid grid(2, scale);
    const Eigen::Vector3d by_m = scale * Eigen::Vector3d(0.004, 0.006, -0.003);
    grid.move(0, by_m, {0.0, 0.002, 0.0});
    for (const CrossingCheck& check : grid.checks()) {
      const bool moved = check.crossing.along_x == 0;
      // The points ask for the way back.
      EXPECT_NEAR(check.rotation_rad.y(), moved ? -0.002 : 0.0, 2e-4);
      EXPECT_NEAR(check.motion_m.y(), moved ? -by_m.y() : 0.0, 8e-4 * scale);
      const auto faults = crossing_faults(grid.set, check, 0.125 * scale);
      EXPECT_EQ(faults.empty(), !moved);
      if (moved) {
        EXPECT_THAT(faults, ElementsAre(AllOf(HasSubstr("lines x0 and z"), HasSubstr("rotation")),
                                        HasSubstr("displacement")));
      }
    }
  }
}

TEST(CheckCrossings, NamesLinesWithoutCommonPoints) {
  CheckedGrid grid(3);
  for (const int frame : grid.set.lines[2].frames) grid.poses[frame].reset();
  for (const CrossingCheck& check : grid.checks()) {
    const bool blind = check.crossing.along_z == 2;
    EXPECT_EQ(check.points == 0, blind);
    if (blind) {
      EXPECT_THAT(crossing_faults(grid.set, check, 0.125),
                  ElementsAre(HasSubstr("only 0 held-out scene points")));
    }
  }
}

TEST(CheckCrossings, SaysWhenItCannotTell) {
  CheckedGrid grid(4);
  for (auto& pose : grid.poses) pose->rotation_sigma_deg = 0.5;
  EXPECT_THAT(crossing_faults(grid.set, grid.checks().front(), 0.125),
              ElementsAre(HasSubstr("too coarsely for a check")));
}

}  // namespace
}  // namespace raywalk::calibrate
