#include "capture/slider/carriage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "simulator/rig/test_slider.h"

namespace raywalk::capture {
namespace {

const SoftLimits kLimits(0.0, 1000.0);

// A carriage on the simulated drive, in simulated time. At the default profile it passes 200 mm of
// a longer move 2.25 s after the start.
class CarriageTest : public ::testing::Test {
 protected:
  void use(const TestSlider::Setup& setup = {}) {
    carriage_.reset();  // before its slider
    slider_.emplace(setup, &clock_);
    carriage_.emplace(slider_->driver(), &clock_, kLimits, rules_);
  }
  void fail(const Fault& fault) { slider_->faults.add(fault); }
  // One reading of the position.
  void put_off(double by_mm, double after_ms) {
    fail({.kind = RigFault::kCorruptedReply, .amount = by_mm, .after_ms = after_ms});
  }
  SettledPosition go_to(double mm) { return carriage_->move_to(kLimits.require(mm, "test")); }

  void expect_fault(FaultKind kind, const std::string& message, double target_mm = 500.0) {
    raywalk::capture::expect_fault(kind, message, [&] { go_to(target_mm); });
  }
  void expect_not_home(FaultKind kind, const std::string& message) {
    raywalk::capture::expect_fault(kind, message, [this] { carriage_->home(); });
    EXPECT_FALSE(slider_->is_moving());
  }
  void start_move(double mm, double for_ms) {
    slider_->driver()->start_move(kLimits.require(mm, "test"), MotionProfile{});
    clock_.sleep(duration_from_ms(for_ms));
  }

  ManualClock clock_;
  MotionRules rules_;
  std::optional<TestSlider> slider_;
  std::optional<Carriage> carriage_;
};

TEST_F(CarriageTest, SettlesAtTheTarget) {
  use({.noise_mm = 0.01});
  const SettledPosition settled = go_to(500.0);
  EXPECT_EQ(settled.commanded_mm, 500.0);
  EXPECT_NEAR(settled.measured_mm, 500.0, 0.02);
  EXPECT_NEAR(settled.moving_ms, 5500.0, 100.0);  // 500 mm at 100 mm/s and 200 mm/s^2
  EXPECT_GE(settled.settling_ms, 300.0);
  EXPECT_EQ(settled.settled_at, clock_.now());
  EXPECT_FALSE(slider_->is_moving());
  EXPECT_EQ(slider_->stops_commanded(), 0);
}

TEST_F(CarriageTest, EveryReadingIsWatched) {
  use();
  std::vector<double> seen;
  carriage_->watch([&](WallTime /*time*/, double mm) { seen.push_back(mm); });
  go_to(10.0);
  EXPECT_GT(seen.size(), 30u);
  EXPECT_EQ(seen.front(), 0.0);
  EXPECT_EQ(seen.back(), 10.0);
}

TEST_F(CarriageTest, SettlesWithoutFlagsFromTheDriveAndOnSlowPasses) {
  use({.reports_flags = false});
  EXPECT_NEAR(go_to(20.0).measured_mm, 20.0, 0.1);
  EXPECT_NEAR(go_to(20.05).measured_mm, 20.05, 0.1);
  use();
  EXPECT_NEAR(carriage_->move_to(kLimits.require(1.0, "test"), {0.05, 200.0}).measured_mm, 1.0,
              0.1);
}

TEST_F(CarriageTest, AlarmStops) {
  use();
  fail({.kind = RigFault::kAlarm, .amount = 17.0, .after_ms = 2250.0});
  expect_fault(FaultKind::kAlarm, "alarm 17");
  EXPECT_FALSE(slider_->is_moving());
  expect_fault(FaultKind::kAlarm, "alarm 17", 100.0);
  EXPECT_EQ(slider_->moves_commanded(), 1);
}

TEST_F(CarriageTest, FaultsDuringAMoveStop) {
  struct Case {
    Fault fault;
    FaultKind kind;
    std::string words;
  };
  for (const Case& each : std::vector<Case>{
           {{.kind = RigFault::kHighLimit, .after_ms = 2250.0},
            FaultKind::kLimitSwitch,
            "high limit switch"},
           // On the wrong side.
           {{.kind = RigFault::kLowLimit, .after_ms = 2250.0},
            FaultKind::kLimitSwitch,
            "low limit switch"},
           {{.kind = RigFault::kStall, .after_ms = 2280.0}, FaultKind::kStall, "stalled at 20"},
           {{.kind = RigFault::kFeedbackDrift, .amount = 1.5, .after_ms = 5400.0},
            FaultKind::kFollowingError,
            "off its target 500.000 mm"},
           {{.kind = RigFault::kFeedbackDrift, .amount = -10000.0, .after_ms = 320.0},
            FaultKind::kLimitSwitch,
            "outside the soft limits"}}) {
    SCOPED_TRACE(each.words);
    use();
    fail(each.fault);
    expect_fault(each.kind, each.words);
    EXPECT_FALSE(slider_->is_moving());
  }
}

TEST_F(CarriageTest, LimitSwitchMayBeLeftButNotRunInto) {
  use({.start_mm = 300.0});
  fail({.kind = RigFault::kHighLimit, .for_ms = 2000.0});
  expect_fault(FaultKind::kLimitSwitch, "high limit switch", 400.0);
  use({.start_mm = 300.0});
  fail({.kind = RigFault::kHighLimit, .for_ms = 2000.0});
  EXPECT_NEAR(go_to(100.0).measured_mm, 100.0, 0.1);
}

TEST_F(CarriageTest, OneWrongReadingNeitherStopsNorSettlesNorShiftsThePath) {
  use();
  put_off(800.0, 0.0);
  put_off(400.0, 1250.0);
  put_off(-900.0, 1500.0);
  EXPECT_NEAR(go_to(500.0).measured_mm, 500.0, 0.1);
  EXPECT_EQ(slider_->stops_commanded(), 0);
}

TEST_F(CarriageTest, WrongReadingRestartsTheDwell) {
  use();
  const double undisturbed = go_to(500.0).settling_ms;
  use();
  put_off(0.5, 5700.0);
  const SettledPosition settled = go_to(500.0);
  EXPECT_GT(settled.settling_ms, undisturbed + 150.0);
  EXPECT_NEAR(settled.measured_mm, 500.0, 1e-9);
}

TEST_F(CarriageTest, DrivesThatDoNotObeyAreReported) {
  use();
  slider_->ignores_commands = true;
  expect_fault(FaultKind::kStall, "does not move");
  EXPECT_EQ(slider_->stops_commanded(), 1);
  use({.max_speed_mm_s = 20.0});
  expect_fault(FaultKind::kTimeout, "has not arrived");
  EXPECT_FALSE(slider_->is_moving());
}

TEST_F(CarriageTest, StopAfterLossOfContactIsNotConfirmed) {
  use();
  fail({.kind = RigFault::kCut, .after_ms = 2250.0});
  expect_fault(FaultKind::kNoContact, "NOT known to have stopped: switch the drive off");
}

TEST_F(CarriageTest, RestoredContactEndsInAConfirmedStop) {
  use();
  // A reading fails, then the first stop command; the second one arrives.
  for (int i = 0; i < 2; ++i) fail({.kind = RigFault::kLostRequest, .after_ms = 2250.0});
  expect_fault(FaultKind::kNoContact, "(stopped at ");
  EXPECT_FALSE(slider_->is_moving());
  EXPECT_EQ(slider_->stops_commanded(), 1);
}

TEST_F(CarriageTest, StopThatHasNoEffectIsReported) {
  rules_.profile = {10.0, 200.0};
  rules_.settle_timeout_ms = 1000.0;
  use();
  slider_->ignores_stop = true;
  fail({.kind = RigFault::kFeedbackJump, .amount = -500.0, .for_ms = 500.0, .after_ms = 1000.0});
  expect_fault(FaultKind::kLimitSwitch, "NOT known to have stopped", 900.0);
  EXPECT_THROW(carriage_->stop(), DeviceFault);
}

TEST_F(CarriageTest, ExceptionOfTheWatchStopsAndPassesThrough) {
  use();
  int readings = 0;
  carriage_->watch([&](WallTime /*time*/, double /*mm*/) {
    if (++readings == 40) throw std::logic_error("journal");
  });
  EXPECT_THROW(go_to(500.0), std::logic_error);
  EXPECT_FALSE(slider_->is_moving());
  EXPECT_EQ(slider_->stops_commanded(), 1);
}

TEST_F(CarriageTest, StopWaitsForStandstill) {
  use();
  start_move(500.0, 1000.0);
  carriage_->stop();
  EXPECT_FALSE(slider_->is_moving());
  EXPECT_NEAR(slider_->true_position_mm(), 76.0, 1.0);  // 75 mm and 1 mm of deceleration
}

TEST_F(CarriageTest, MotionStartedByAnotherProgramIsStoppedFirst) {
  use();
  start_move(900.0, 2000.0);
  EXPECT_NEAR(go_to(50.0).measured_mm, 50.0, 0.1);
  EXPECT_EQ(slider_->stops_commanded(), 1);
}

TEST_F(CarriageTest, FindsHomeWithAndWithoutFlagsAndAgain) {
  for (const bool flags : {true, false}) {
    use({.start_mm = 321.0, .homed = false, .reports_flags = flags});
    if (flags) expect_fault(FaultKind::kAlarm, "home first");
    EXPECT_EQ(slider_->moves_commanded(), 0);
    carriage_->home();
    EXPECT_NEAR(slider_->true_position_mm(), 0.0, 1e-9);
    EXPECT_NEAR(go_to(10.0).measured_mm, 10.0, 0.1);
    carriage_->home();
    if (flags) carriage_->home();
    EXPECT_NEAR(slider_->true_position_mm(), 0.0, 1e-9);
  }
}

// A drive that has just been switched on shows 0.
TEST_F(CarriageTest, ZeroWithoutMotionIsNoHome) {
  use({.start_mm = 321.0, .homed = false, .reports_flags = false});
  slider_->ignores_commands = true;
  EXPECT_THROW(carriage_->home(), DeviceFault);
}

TEST_F(CarriageTest, HomingThatStallsOrTakesTooLongStops) {
  use({.start_mm = 321.0, .homed = false});
  fail({.kind = RigFault::kStall, .after_ms = 1200.0});
  expect_not_home(FaultKind::kStall, "without having found home");
  EXPECT_EQ(slider_->stops_commanded(), 1);
  rules_.homing_timeout_ms = 2000.0;
  use({.start_mm = 900.0, .homed = false});
  expect_not_home(FaultKind::kTimeout, "not home after 2 s");
}

// In a separate process: the interrupt flag is never cleared.
TEST_F(CarriageTest, InterruptDeceleratesAndWaitsForStandstill) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        use();
        int readings = 0;
        carriage_->watch([&](WallTime /*time*/, double /*mm*/) {
          if (++readings == 100) std::raise(SIGTERM);
        });
        try {
          go_to(500.0);
        } catch (const Interrupted&) {
          std::_Exit(slider_->is_moving() || slider_->stops_commanded() != 1 ? 1 : 0);
        }
        std::_Exit(2);
      },
      ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace raywalk::capture
