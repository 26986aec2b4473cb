// Thousands of moves with random profiles, noise and faults: the results of Carriage must be true.
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <random>

#include "capture/base/device_fault.h"
#include "capture/base/manual_clock.h"
#include "capture/slider/carriage.h"
#include "simulator/rig/test_slider.h"

namespace raywalk::capture {
namespace {

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
      slider.faults.add(
          {.kind = RigFault::kCorruptedReply, .amount = size_mm, .after_ms = after_ms});
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
  const std::vector<RigFault> kinds{RigFault::kStall,         RigFault::kAlarm,
                                    RigFault::kLowLimit,      RigFault::kHighLimit,
                                    RigFault::kFeedbackDrift, RigFault::kCut};
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
    const bool drifts = kind == RigFault::kFeedbackDrift;
    slider.faults.add({.kind = kind,
                       .amount = rig.uniform(20.0, 200.0),
                       .for_ms = kind == RigFault::kAlarm ? 0.0 : for_ms,
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
      slider.faults.add({.kind = RigFault::kStall, .after_ms = rig.fault_after_ms()});
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

}  // namespace
}  // namespace raywalk::capture
