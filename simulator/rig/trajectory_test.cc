#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "simulator/rig/simulated_drive.h"

namespace raywalk::capture {
namespace {

TEST(TrajectoryTest, LongMoveIsATrapezoid) {
  // 100 mm/s after 0.5 s and 25 mm; 350 mm at that speed; 25 mm of braking.
  const auto move = Trajectory::to(400.0, {0.0, 0.0}, {100.0, 200.0, 200.0});
  EXPECT_NEAR(move.duration_s(), 0.5 + 3.5 + 0.5, 1e-12);
  EXPECT_NEAR(move.at(0.5).position_mm, 25.0, 1e-9);
  EXPECT_NEAR(move.at(2.0).speed_mm_s, 100.0, 1e-9);
  EXPECT_NEAR(move.at(2.0).position_mm, 175.0, 1e-9);
  EXPECT_EQ(move.at(99.0).position_mm, 400.0);
  EXPECT_EQ(move.at(99.0).speed_mm_s, 0.0);
}

TEST(TrajectoryTest, ShortMoveNeverReachesFullSpeed) {
  // Half the way at 200 mm/s^2: v^2 = 2 * 200 * 0.5.
  const auto move = Trajectory::to(-1.0, {0.0, 0.0}, {100.0, 200.0, 200.0});
  EXPECT_NEAR(move.at(0.5 * move.duration_s()).speed_mm_s, -std::sqrt(200.0), 1e-9);
}

TEST(TrajectoryTest, TargetWithinTheBrakingDistanceIsOvershot) {
  // From 100 mm/s at 200 mm/s^2 it stops after 25 mm.
  const auto move = Trajectory::to(10.0, {0.0, 100.0}, {100.0, 200.0, 200.0});
  EXPECT_NEAR(move.at(0.5).position_mm, 25.0, 1e-9);
  EXPECT_NEAR(move.at(0.5).speed_mm_s, 0.0, 1e-9);
  EXPECT_EQ(move.at(move.duration_s()).position_mm, 10.0);
}

TEST(TrajectoryTest, BrakingDistanceIsVSquaredOverTwoA) {
  const auto halt = Trajectory::halt({5.0, -100.0}, 400.0);
  EXPECT_NEAR(halt.end_mm(), 5.0 - 12.5, 1e-12);
  EXPECT_NEAR(halt.duration_s(), 0.25, 1e-12);
}

TEST(TrajectoryTest, MotionToTheCurrentPositionTakesNoTime) {
  EXPECT_EQ(Trajectory::to(3.0, {3.0, 0.0}, {}).duration_s(), 0.0);
}

double log_uniform(std::mt19937* random, double min, double max) {
  return std::exp(std::uniform_real_distribution<double>(std::log(min), std::log(max))(*random));
}

// Position and speed are continuous; acceleration and speed stay within their bounds.
TEST(TrajectoryTest, AnyMotionIsContinuousAndWithinItsBounds) {
  std::mt19937 random(4);
  for (int i = 0; i < 5000; ++i) {
    const auto sign = [&] { return random() % 2 == 0 ? 1.0 : -1.0; };
    const MotionBounds bounds{log_uniform(&random, 1e-2, 1e4), log_uniform(&random, 1e-1, 1e5),
                              log_uniform(&random, 1e-1, 1e5)};
    const MotionState start{sign() * log_uniform(&random, 1e-3, 1e4),
                            i % 3 == 0 ? 0.0 : sign() * log_uniform(&random, 1e-2, 1e4)};
    const double target_mm = sign() * log_uniform(&random, 1e-3, 1e4);
    const auto move = Trajectory::to(target_mm, start, bounds);
    const double fastest = std::max(bounds.speed_mm_s, std::abs(start.speed_mm_s));
    MotionState before = start;
    double reach_mm = std::max(std::abs(start.position_mm), std::abs(target_mm));
    for (const Trajectory::Phase& phase : move.phases()) {
      reach_mm = std::max(reach_mm, std::abs(phase.start.position_mm));
      EXPECT_NEAR(phase.start.position_mm, before.position_mm, 1e-9 * reach_mm);
      EXPECT_NEAR(phase.start.speed_mm_s, before.speed_mm_s, 1e-7 * fastest);
      EXPECT_LE(std::abs(phase.start.speed_mm_s), fastest * (1.0 + 1e-9));
      EXPECT_LE(std::abs(phase.acceleration_mm_s2),
                std::max(bounds.acceleration_mm_s2, bounds.deceleration_mm_s2));
      before = {phase.start.position_mm +
                    (phase.start.speed_mm_s + 0.5 * phase.acceleration_mm_s2 * phase.duration_s) *
                        phase.duration_s,
                phase.start.speed_mm_s + phase.acceleration_mm_s2 * phase.duration_s};
    }
    EXPECT_NEAR(before.position_mm, target_mm, 1e-6 * reach_mm) << i;
    // A rounding error of the distance leaves a speed of its square root.
    EXPECT_NEAR(before.speed_mm_s, 0.0, 1e-6 * fastest) << i;
  }
}

}  // namespace
}  // namespace raywalk::capture
