#include "capture/slider/carriage.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <csignal>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/slider/soft_limits.h"
#include "core/base/interrupt.h"
#include "core/files/test_support.h"
#include "simulator/rig/test_slider.h"

namespace raywalk::capture {
namespace {

using enum RigFault;

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
    fail({.kind = kCorruptedReply, .amount = by_mm, .after_ms = after_ms});
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

TEST_F(CarriageTest, SettlesWithoutFlagsFromTheDriveAndOnSlowPasses) {
  use({.reports_flags = false});
  for (const double mm : {20.0, 20.05}) EXPECT_NEAR(go_to(mm).measured_mm, mm, 0.1);
  use();
  EXPECT_NEAR(carriage_->move_to(kLimits.require(1.0, "test"), {0.05, 200.0}).measured_mm, 1.0,
              0.1);
}

TEST_F(CarriageTest, FaultsDuringAMoveStop) {
  struct Case {
    FaultKind kind;
    std::string words;
    Fault fault;
  };
  const Case cases[] = {
      {FaultKind::kAlarm, "alarm 17", {.kind = kAlarm, .amount = 17.0, .after_ms = 2250.0}},
      {FaultKind::kLimitSwitch, "high limit switch", {.kind = kHighLimit, .after_ms = 2250.0}},
      // On the wrong side.
      {FaultKind::kLimitSwitch, "low limit switch", {.kind = kLowLimit, .after_ms = 2250.0}},
      {FaultKind::kStall, "stalled at 20", {.kind = kStall, .after_ms = 2280.0}},
      {FaultKind::kFollowingError,
       "off its target 500.000 mm",
       {.kind = kFeedbackDrift, .amount = 1.5, .after_ms = 5400.0}},
      {FaultKind::kLimitSwitch,
       "outside the soft limits",
       {.kind = kFeedbackDrift, .amount = -10000.0, .after_ms = 320.0}}};
  for (const Case& each : cases) {
    SCOPED_TRACE(each.words);
    use();
    fail(each.fault);
    expect_fault(each.kind, each.words);
    EXPECT_FALSE(slider_->is_moving());
    if (each.kind != FaultKind::kAlarm) continue;
    expect_fault(FaultKind::kAlarm, "alarm 17", 100.0);  // until it is cleared
    EXPECT_EQ(slider_->moves_commanded(), 1);
  }
}

TEST_F(CarriageTest, LimitSwitchMayBeLeftButNotRunInto) {
  use({.start_mm = 300.0});
  fail({.kind = kHighLimit, .for_ms = 2000.0});
  expect_fault(FaultKind::kLimitSwitch, "high limit switch", 400.0);
  use({.start_mm = 300.0});
  fail({.kind = kHighLimit, .for_ms = 2000.0});
  EXPECT_NEAR(go_to(100.0).measured_mm, 100.0, 0.1);
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
  fail({.kind = kCut, .after_ms = 2250.0});
  expect_fault(FaultKind::kNoContact, "NOT known to have stopped: switch the drive off");
}

TEST_F(CarriageTest, RestoredContactEndsInAConfirmedStop) {
  use();
  // A reading fails, then the first stop command; the second one arrives.
  for (int i = 0; i < 2; ++i) fail({.kind = kLostRequest, .after_ms = 2250.0});
  expect_fault(FaultKind::kNoContact, "(stopped at ");
  EXPECT_FALSE(slider_->is_moving());
  EXPECT_EQ(slider_->stops_commanded(), 1);
}

TEST_F(CarriageTest, StopThatHasNoEffectIsReported) {
  rules_.profile = {10.0, 200.0};
  rules_.settle_timeout_ms = 1000.0;
  use();
  slider_->ignores_stop = true;
  fail({.kind = kFeedbackJump, .amount = -500.0, .for_ms = 500.0, .after_ms = 1000.0});
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
  fail({.kind = kStall, .after_ms = 1200.0});
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
        EXPECT_THROW(go_to(500.0), Interrupted);
        EXPECT_FALSE(slider_->is_moving());
        EXPECT_EQ(slider_->stops_commanded(), 1);
        std::_Exit(HasFailure() ? 1 : 0);
      },
      ::testing::ExitedWithCode(0), "");
}

// --- Thousands of moves with random profiles, noise and faults: the results must be true --------

constexpr double kRail_mm = 2000.0;

class RandomRig {
 public:
  // Failed stops are expected; no log.
  explicit RandomRig(std::uint64_t seed) : random_(seed) { spdlog::set_level(spdlog::level::off); }
  ~RandomRig() { spdlog::set_level(spdlog::level::info); }

  double uniform(double low, double high) {
    return std::uniform_real_distribution(low, high)(random_);
  }
  double log_uniform(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }
  bool chance(double share) { return uniform(0.0, 1.0) < share; }

  MotionRules rules() {
    MotionRules rules;
    rules.profile = {log_uniform(5.0, 1000.0), log_uniform(20.0, 5000.0)};
    rules.settle_tolerance_mm = log_uniform(0.02, 1.0);
    rules.settle_ms = uniform(0.0, 500.0);
    rules.poll_ms = log_uniform(5.0, 60.0);
    return rules;
  }
  TestSlider::Setup slider(const MotionRules& rules) {
    TestSlider::Setup setup;
    setup.seed = static_cast<int>(random_() % 1000000);
    setup.start_mm = uniform(0.0, kRail_mm);
    setup.reports_flags = chance(0.5);
    setup.noise_mm = chance(0.5) ? rules.settle_tolerance_mm * uniform(0.0, 0.2) : 0.0;
    return setup;
  }
  double fault_after_ms() { return log_uniform(1.0, 20000.0); }
  // A whole step of the drive.
  SafePosition target() {
    return limits.require(1e-3 * std::round(1e3 * uniform(0.0, kRail_mm)), "test");
  }

  const SoftLimits limits{-5.0, kRail_mm + 5.0};

 private:
  std::mt19937_64 random_;
};

TEST(CarriagePropertyTest, GoodDrivesAlwaysSettleWhereTheyTrulyAre) {
  RandomRig rig(11);
  for (int i = 0; i < 1500; ++i) {
    ManualClock clock;
    const MotionRules rules = rig.rules();
    TestSlider slider(rig.slider(rules), &clock);
    Carriage carriage(slider.driver(), &clock, rig.limits, rules);
    for (int move = 0; move < 3; ++move) {
      const SafePosition target = rig.target();
      const SettledPosition settled = carriage.move_to(target);
      ASSERT_NEAR(slider.true_position_mm(), target.mm(), rules.settle_tolerance_mm) << i;
      ASSERT_NEAR(settled.measured_mm, target.mm(), rules.settle_tolerance_mm) << i;
    }
    EXPECT_EQ(slider.stops_commanded(), 0);
  }
}

// Single wrong readings, random in number and size, cost only time.
TEST(CarriagePropertyTest, OutliersNeverStopAMoveNorSettleItElsewhere) {
  RandomRig rig(12);
  for (int i = 0; i < 1500; ++i) {
    ManualClock clock;
    const MotionRules rules = rig.rules();
    TestSlider slider(rig.slider(rules), &clock);
    double after_ms = 0.0;
    for (int outlier = 0; outlier < 10; ++outlier) {
      after_ms += rig.uniform(2.0, 10.0) * (rules.poll_ms + 60.0);  // never two in a row
      const double size_mm = (rig.chance(0.5) ? 1.0 : -1.0) * rig.log_uniform(0.01, 1e5);
      slider.faults.add({.kind = kCorruptedReply, .amount = size_mm, .after_ms = after_ms});
    }
    Carriage carriage(slider.driver(), &clock, rig.limits, rules);
    const SafePosition target = rig.target();
    const SettledPosition settled = carriage.move_to(target);
    ASSERT_NEAR(slider.true_position_mm(), target.mm(), rules.settle_tolerance_mm) << i;
    ASSERT_NEAR(settled.measured_mm, target.mm(), rules.settle_tolerance_mm) << i;
  }
}

// Faults at random moments: the carriage settles at the target, or is at rest, or the message says
// that the stop is not confirmed.
TEST(CarriagePropertyTest, FaultsNeverGiveAWrongPositionNorUnreportedMotion) {
  RandomRig rig(13);
  const std::vector<RigFault> kinds{kStall, kAlarm, kLowLimit, kHighLimit, kFeedbackDrift, kCut};
  int faults = 0;
  for (int i = 0; i < 2000; ++i) {
    ManualClock clock;
    const MotionRules rules = rig.rules();
    TestSlider slider(rig.slider(rules), &clock);
    const double after_ms = rig.fault_after_ms();
    const double for_ms = rig.chance(0.5) ? 0.0 : rig.log_uniform(10.0, 10000.0);
    // Every fourth drive ignores a move or a stop besides.
    slider.ignores_commands = i % 8 == 3;
    slider.ignores_stop = i % 8 == 7;
    const RigFault kind = kinds[static_cast<std::size_t>(i) % kinds.size()];
    const bool drifts = kind == kFeedbackDrift;
    slider.faults.add({.kind = kind,
                       .amount = rig.uniform(20.0, 200.0),
                       .for_ms = kind == kAlarm ? 0.0 : for_ms,
                       .after_ms = after_ms});
    const double start_mm = slider.true_position_mm();
    Carriage carriage(slider.driver(), &clock, rig.limits, rules);
    const SafePosition target = rig.target();
    try {
      carriage.move_to(target);
      // A program cannot see the drift of an encoder.
      const double tolerance = drifts ? 20.0 : rules.settle_tolerance_mm;
      ASSERT_NEAR(slider.true_position_mm(), target.mm(), tolerance) << i;
    } catch (const DeviceFault& error) {
      ++faults;
      const bool said = std::string(error.what()).find("NOT known") != std::string::npos;
      ASSERT_TRUE(said || !slider.is_moving()) << i << error.what();
    }
    ASSERT_GE(slider.lowest_mm(), std::min(start_mm, target.mm()) - 1e-6) << i;
    ASSERT_LE(slider.highest_mm(), std::max(start_mm, target.mm()) + 1e-6) << i;
  }
  EXPECT_GT(faults, 300);
}

TEST(CarriagePropertyTest, HomingEndsAtHomeOrThrows) {
  RandomRig rig(14);
  int homed = 0;
  for (int i = 0; i < 500; ++i) {
    ManualClock clock;
    const MotionRules rules = rig.rules();
    TestSlider::Setup setup = rig.slider(rules);
    setup.homed = rig.chance(0.5);
    TestSlider slider(setup, &clock);
    if (rig.chance(0.3)) {
      slider.faults.add({.kind = kStall, .after_ms = rig.fault_after_ms()});
    }
    Carriage carriage(slider.driver(), &clock, rig.limits, rules);
    try {
      carriage.home();
      ASSERT_NEAR(slider.true_position_mm(), 0.0, rules.settle_tolerance_mm) << i;
      ++homed;
    } catch (const DeviceFault& error) {
      ASSERT_FALSE(slider.is_moving()) << i << error.what();
    }
  }
  EXPECT_GT(homed, 250);
}

// --- Soft limits, and times of moves ------------------------------------------------------------

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

TEST(SoftLimitsTest, BothEndsAreAllowedAndWhatIsBeyondIsNamed) {
  const SoftLimits limits(10.0, 20.0);
  for (const double mm : {10.0, 20.0}) EXPECT_EQ(limits.require(mm, "station a").mm(), mm);
  for (const double mm :
       {std::nextafter(10.0, 0.0), std::nextafter(20.0, 30.0), -1e300, kInfinity, kNoNumber}) {
    EXPECT_THROW(limits.require(mm, "station c"), UsageError) << mm;
  }
  EXPECT_EQ(error_of([&] { limits.require(20.5, "station x0_003"); }),
            "station x0_003: 20.500 mm is outside the soft limits, 10 to 20 mm");
}

TEST(SoftLimitsTest, EmptyRangesAreRefused) {
  for (const auto& [low, high] :
       {std::pair{5.0, 5.0}, {6.0, 5.0}, {kNoNumber, 5.0}, {0.0, kInfinity}}) {
    EXPECT_THROW(SoftLimits(low, high), UsageError) << low;
  }
}

TEST(MotionProfileTest, TimesOfATrapezoid) {
  const MotionProfile profile{100.0, 200.0};
  // Ramps of 0.5 s and 25 mm each, 50 mm at 100 mm/s between them.
  EXPECT_DOUBLE_EQ(profile.moving_ms(100.0), 1500.0);
  EXPECT_DOUBLE_EQ(profile.moving_ms(2.0), 200.0);  // 2 sqrt(d/a), without a cruise
  EXPECT_EQ(profile.moving_ms(0.0), 0.0);
  EXPECT_DOUBLE_EQ(profile.stopping_ms(), 500.0);
}

}  // namespace
}  // namespace raywalk::capture
