#include "simulator/rig/simulated_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "capture/base/manual_clock.h"

namespace raywalk::simulator {
namespace {

using namespace capture;

constexpr MotionBounds kDriveBounds{100.0, 200.0, 200.0};

class SimulatedDriveTest : public ::testing::Test {
 protected:
  SimulatedDriveTest() { use({.backlash_mm = 0.0}); }

  // A homed drive of these settings.
  void use(const DriveSettings& settings) {
    drive.emplace(settings, &clock_, &faults_);
    drive->home();
    pass(60000.0);
  }
  void pass(double ms) { clock_.sleep(duration_from_ms(ms)); }
  // Commands a move and lets time pass.
  void move(double target_mm, double ms) {
    drive->move_to(target_mm, kDriveBounds);
    pass(ms);
  }
  void expect_at(double feedback_mm, bool moving, double carriage_mm) {
    const DriveState state = drive->state();
    EXPECT_NEAR(state.feedback_mm, feedback_mm, 1e-6);
    EXPECT_EQ(state.moving, moving);
    EXPECT_EQ(state.in_position, !moving);
    EXPECT_NEAR(drive->truth().carriage_mm, carriage_mm, 1e-6);
  }
  void expect_at(double mm, bool moving = false) { expect_at(mm, moving, mm); }

  ManualClock clock_;
  Faults faults_{&clock_};
  std::optional<SimulatedDrive> drive;
};

TEST_F(SimulatedDriveTest, HomingMakesTheSwitchZeroFromBothOfItsSides) {
  for (const double power_on_mm : {300.0, -10.0}) {
    drive.emplace(DriveSettings{.power_on_mm = power_on_mm, .backlash_mm = 0.0}, &clock_, &faults_);
    EXPECT_FALSE(drive->state().homed);
    expect_at(0.0, false, power_on_mm);  // the drive does not know yet where it is
    drive->home();
    pass(100.0);
    EXPECT_TRUE(drive->state().moving);
    EXPECT_FALSE(drive->state().homed);
    pass(60000.0);
    EXPECT_TRUE(drive->state().homed);
    expect_at(0.0);
  }
}

TEST_F(SimulatedDriveTest, FollowsTheMotionProfile) {
  move(400.0, 500.0);
  expect_at(25.0, true);
  EXPECT_FALSE(drive->truth().still_for);
  pass(4000.0 + 70.0);
  expect_at(400.0);
  ASSERT_TRUE(drive->truth().still_for);
  EXPECT_NEAR(ms_from_duration(*drive->truth().still_for), 70.0, 1e-3);
  use({.max_speed_mm_s = 10.0});
  drive->move_to(1000.0, {1e6, 1e6, 1e6});
  pass(10000.0);
  EXPECT_LT(drive->state().feedback_mm, 100.0);
}

// A reversal between two readings counts for the visited positions.
TEST_F(SimulatedDriveTest, ExtremesIncludeUnobservedReversals) {
  move(1000.0, 1500.0);  // at 125 mm, 100 mm/s: halts at 150 mm
  move(50.0, 60000.0);
  expect_at(50.0);
  const DriveTruth truth = drive->truth();
  EXPECT_NEAR(truth.visited.high_mm, 150.0, 1e-6);
  EXPECT_NEAR(truth.visited.low_mm, 0.0, 1e-9);
  EXPECT_EQ(truth.commanded.high_mm, 1000.0);
  EXPECT_EQ(truth.commanded.low_mm, 50.0);
  EXPECT_EQ(truth.moves, 2);
}

TEST_F(SimulatedDriveTest, CarriageLagsTheMotorByTheBacklash) {
  use({.backlash_mm = 0.4});
  move(100.0, 60000.0);
  expect_at(100.0, false, 99.6);
  move(50.0, 60000.0);
  expect_at(50.0);
}

TEST_F(SimulatedDriveTest, NoiseHasTheGivenDeviationAndIsSeeded) {
  const DriveSettings settings{.backlash_mm = 0.0, .feedback_noise_mm = 0.05};
  SimulatedDrive noisy(settings, &clock_, &faults_), again(settings, &clock_, &faults_);
  double sum = 0.0, squares = 0.0;
  constexpr int kReadings = 4000;
  for (int i = 0; i < kReadings; ++i) {
    const double reading = noisy.state().feedback_mm;
    EXPECT_EQ(again.state().feedback_mm, reading);
    sum += reading;
    squares += reading * reading;
  }
  EXPECT_NEAR(sum / kReadings, 0.0, 0.005);
  EXPECT_NEAR(std::sqrt(squares / kReadings), 0.05, 0.003);
}

TEST_F(SimulatedDriveTest, StopDeceleratesAndStays) {
  move(1000.0, 2000.0);
  drive->stop();
  pass(60000.0);
  expect_at(177.5);  // 175 mm, then 100^2 / (2 * 2000) of braking
}

TEST_F(SimulatedDriveTest, LimitSwitchesStopTheMotorButAllowReturning) {
  move(5000.0, 60000.0);
  expect_at(2000.0);
  EXPECT_TRUE(drive->state().at_high_limit);
  move(6000.0, 1000.0);
  expect_at(2000.0);
  move(1900.0, 60000.0);
  expect_at(1900.0);
  EXPECT_FALSE(drive->state().at_high_limit);
  // A fault of the switch refuses its side only.
  faults_.add({.kind = RigFault::kHighLimit, .for_ms = 10000.0});
  EXPECT_TRUE(drive->state().at_high_limit);
  move(1950.0, 2000.0);
  expect_at(1900.0);
  move(1800.0, 9000.0);
  expect_at(1800.0);
  EXPECT_FALSE(drive->state().at_high_limit);
}

TEST_F(SimulatedDriveTest, StalledMotorIsReportedAsMovingAndGoesOnWhenFreed) {
  move(400.0, 1000.0);
  faults_.add({.kind = RigFault::kStall, .for_ms = 3000.0});
  pass(2000.0);
  expect_at(75.0, true);
  pass(60000.0);
  expect_at(400.0);
  faults_.add({.kind = RigFault::kStall});
  move(10.0, 60000.0);
  expect_at(400.0, true);
  faults_.clear();
  drive->state();
  pass(60000.0);
  expect_at(10.0);
}

TEST_F(SimulatedDriveTest, AlarmHaltsUntilItIsReset) {
  move(400.0, 1000.0);
  faults_.add({.kind = RigFault::kAlarm, .amount = 0x210});
  pass(5000.0);
  const DriveState state = drive->state();
  EXPECT_TRUE(state.alarm);
  EXPECT_EQ(state.alarm_code, 0x210);
  EXPECT_FALSE(state.enabled);
  EXPECT_FALSE(state.moving);
  move(300.0, 5000.0);
  EXPECT_EQ(drive->state().feedback_mm, state.feedback_mm);
  drive->reset_alarm();
  EXPECT_FALSE(drive->state().alarm);
  move(300.0, 60000.0);
  expect_at(300.0);
}

TEST_F(SimulatedDriveTest, FeedbackFaultsDoNotMoveTheCarriage) {
  faults_.add({.kind = RigFault::kFeedbackJump, .amount = 3.0, .for_ms = 1000.0});
  expect_at(3.0, false, 0.0);
  pass(1000.0);
  expect_at(0.0);
  faults_.add({.kind = RigFault::kFeedbackDrift, .amount = 2.0});
  pass(500.0);
  expect_at(1.0, false, 0.0);
  faults_.clear();
  expect_at(0.0);
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
}  // namespace raywalk::simulator
