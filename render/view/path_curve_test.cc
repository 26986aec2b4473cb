#include "render/view/path_curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/error.h"
#include "core/base/test_error.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

PathView pose_at(double x_m, double z_m, double yaw_deg = 0.0, double time_s = 0.0) {
  return {.name = "at" + std::to_string(x_m),
          .viewpoint = PlanPoint{x_m, z_m},
          .yaw_deg = yaw_deg,
          .time_s = time_s};
}

double distance(const PathView& a, const PathView& b) {
  return std::hypot(a.viewpoint.plan.x_m - b.viewpoint.plan.x_m,
                    a.viewpoint.plan.z_m - b.viewpoint.plan.z_m);
}

// Paths of 2 to 9 places, some of them twice, in rooms of a tenth of a millimetre to 100 km.
std::vector<PathView> random_path(std::mt19937* random, double scale_m) {
  std::uniform_real_distribution<double> within(-scale_m, scale_m);
  std::vector<PathView> views;
  const int count = 2 + static_cast<int>((*random)() % 8);
  for (int i = 0; i < count; ++i) {
    views.push_back(pose_at(within(*random), within(*random)));
    if ((*random)() % 4 == 0) views.push_back(views.back());
  }
  return views;
}

TEST(PathCurve, GoesThroughEveryPlaceAtAConstantSpeed) {
  std::mt19937 random(7);
  for (const double scale_m : {1e-4, 1.0, 1e5}) {
    for (int round = 0; round < 20; ++round) {
      const std::vector<PathView> views = random_path(&random, scale_m);
      const PathCurve curve(views, Pace::kConstant);
      constexpr int kSteps = 4000;
      int bends = 0;
      std::vector<double> nearest(views.size(), 1e9);
      PathView before = curve.at(0.0);
      const double step_m = curve.length() / kSteps;
      for (int i = 0; i <= kSteps; ++i) {
        const PathView here = curve.at(step_m * i);
        for (std::size_t k = 0; k < views.size(); ++k) {
          nearest[k] = std::min(nearest[k], distance(here, views[k]));
        }
        if (i > 0) {
          EXPECT_LT(distance(before, here), (1.0 + 1e-6) * step_m);
          // In a sharp bend the chord is shorter than the way.
          if (distance(before, here) < 0.99 * step_m) ++bends;
        }
        before = here;
      }
      EXPECT_LT(bends, kSteps / 50);
      for (const double each : nearest) EXPECT_LE(each, 0.6 * step_m);
      EXPECT_EQ(distance(curve.at(0.0), views.front()), 0.0);
      EXPECT_LT(distance(curve.at(curve.length()), views.back()), 1e-12 * scale_m);
    }
  }
}

TEST(PathCurve, EasedMovementsStartAndStopSlowly) {
  const std::vector<PathView> views = {pose_at(0, 0), pose_at(1, 0), pose_at(1, 1)};
  const SmoothMovement movement{.pace = Pace::kEased, .fps = 100.0, .seconds = 2.0};
  const std::vector<PathView> frames = frames_of(views, movement, "walk.csv");
  ASSERT_EQ(frames.size(), 200U);
  EXPECT_EQ(frames[0].name, "walk-00001");
  const double middle = distance(frames[99], frames[100]);
  EXPECT_LT(distance(frames[0], frames[1]), 1e-3 * middle);
  EXPECT_LT(distance(frames[198], frames[199]), 1e-3 * middle);
  EXPECT_LT(distance(frames[199], views[2]), 1e-9);
}

TEST(PathCurve, TurnsTheShortWayAndTakesTimeForIt) {
  const std::vector<PathView> views = {pose_at(0, 0, 170), pose_at(1, 0, -170)};
  const PathCurve curve(views, Pace::kConstant);
  EXPECT_NEAR(curve.at(0.5 * curve.length()).yaw_deg, 180.0, 1e-9);
  EXPECT_NEAR(curve.length(), 1.0, 1e-12);
  // On the spot: 100 degrees are as long as a metre.
  const std::vector<PathView> turn = {pose_at(0, 0, 0), pose_at(0, 0, 80)};
  EXPECT_NEAR(PathCurve(turn, Pace::kConstant).length(), 0.8, 1e-12);
}

TEST(PathCurve, FollowsRecordedTimes) {
  const std::vector<PathView> views = {pose_at(0, 0, 0, 10), pose_at(1, 0, 0, 11),
                                       pose_at(1, 0, 0, 14), pose_at(2, 0, 0, 15)};
  const PathCurve curve(views, Pace::kRecorded);
  EXPECT_NEAR(curve.length(), 5.0, 1e-9);
  for (const PathView& view : views) {
    EXPECT_NEAR(curve.at(view.time_s - 10.0).viewpoint.plan.x_m, view.viewpoint.plan.x_m, 1e-9);
  }
  EXPECT_EQ(frames_of(views, {.pace = Pace::kRecorded, .fps = 10.0}, "walk.csv").size(), 50U);
  const std::vector<PathView> back = {pose_at(0, 0, 0, 1), pose_at(1, 0, 0, 1)};
  EXPECT_THAT(error_of([&] { frames_of(back, {.pace = Pace::kRecorded}, "walk.csv"); }),
              AllOf(HasSubstr("walk.csv: view 'at1"), HasSubstr("growing times")));
}

TEST(PathCurve, MovementsThatMakeNoSenseAreRefused) {
  const std::vector<PathView> still = {pose_at(1, 2), pose_at(1, 2)};
  EXPECT_THAT(error_of([&] { frames_of(still, {}, "walk.csv"); }), HasSubstr("give --seconds"));
  EXPECT_EQ(frames_of(still, {.fps = 10.0, .seconds = 1.0}, "walk.csv").size(), 10U);
  const std::vector<PathView> far = {pose_at(0, 0), pose_at(1e9, 0)};
  EXPECT_THAT(error_of([&] { frames_of(far, {}, "walk.csv"); }), HasSubstr("1e+06 frames"));
  EXPECT_THROW(require_movement({.seconds = 0.0}), UsageError);
  EXPECT_THROW(require_movement({.seconds = std::nan("")}), UsageError);
  EXPECT_THROW(require_movement({.seconds = 1.0, .speed_m_per_s = 1.0}), UsageError);
  EXPECT_THROW(require_movement({.pace = Pace::kRecorded, .speed_m_per_s = 1.0}), UsageError);
}

TEST(PathCurve, HeightsAreFollowedWhereThereAreAny) {
  std::vector<PathView> views{{.name = "a", .viewpoint = {PlanPoint{0, 0}, 1.0}},
                              {.name = "b", .viewpoint = {PlanPoint{0, 0}, 1.5}}};
  const PathCurve up(views, Pace::kConstant);
  EXPECT_NEAR(up.length(), 0.5, 1e-12);
  EXPECT_NEAR(up.at(0.25).viewpoint.height_m.value(), 1.25, 1e-9);
  for (PathView& view : views) view.viewpoint.height_m.reset();
  views.back().viewpoint.plan.x_m = 1.0;
  EXPECT_FALSE(PathCurve(views, Pace::kConstant).at(0.5).viewpoint.height_m.has_value());
}

}  // namespace
}  // namespace raywalk::render
