#include "capture/slider/fake_slider.h"

#include <gtest/gtest.h>

#include "capture/base/device_fault.h"
#include "capture/base/manual_clock.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

const SoftLimits kWideLimits(-1000.0, 1000.0);

class FakeSliderTest : public ::testing::Test {
 protected:
  FakeSlider slider(const std::string& yaml) {
    return {parse_fake_slider_config(yaml, "fake.yaml"), &clock_};
  }
  void pass(double ms) { clock_.sleep(duration_from_ms(ms)); }
  static SafePosition at(double mm) { return kWideLimits.require(mm, "test"); }

  ManualClock clock_;
};

TEST_F(FakeSliderTest, FollowsItsTrapezoidWithinWhatTheMotorCan) {
  FakeSlider fake = slider("most_speed_mm_s: 50");
  fake.start_move(at(100.0), {400.0, 100.0});  // 0.5 s and 12.5 mm of ramp, then 50 mm/s
  pass(1000.0);
  EXPECT_NEAR(fake.read_state().position_mm, 37.5, 1e-6);
  EXPECT_EQ(fake.read_state().moving, true);
  pass(2000.0);
  EXPECT_EQ(fake.read_state().position_mm, 100.0);
  EXPECT_EQ(fake.read_state().in_position, true);
}

TEST_F(FakeSliderTest, StopDecelerates) {
  FakeSlider fake = slider("");
  fake.start_move(at(500.0), {100.0, 200.0});
  pass(1000.0);
  const double before = fake.true_position_mm();
  fake.stop();
  EXPECT_NEAR(fake.true_position_mm(), before, 1e-6);
  EXPECT_TRUE(fake.is_moving());
  pass(500.0);
  EXPECT_FALSE(fake.is_moving());
  EXPECT_NEAR(fake.true_position_mm(), before + 25.0, 1e-6);
}

TEST_F(FakeSliderTest, BacklashHidesFromTheFeedback) {
  FakeSlider fake = slider("start_mm: 50\nbacklash_mm: 0.3");
  fake.start_move(at(10.0), {100.0, 200.0});
  pass(5000.0);
  EXPECT_EQ(fake.read_state().position_mm, 10.0);
  EXPECT_NEAR(fake.true_position_mm(), 10.3, 1e-9);
  fake.start_move(at(20.0), {100.0, 200.0});
  pass(5000.0);
  EXPECT_NEAR(fake.true_position_mm(), 20.0, 1e-9);
}

TEST_F(FakeSliderTest, FaultsBeginAndEndOnTime) {
  FakeSlider fake = slider("faults: [{kind: no-contact, at_ms: 100, for_ms: 50}]");
  EXPECT_NO_THROW(fake.read_state());
  pass(100.0);
  EXPECT_THROW(fake.read_state(), DeviceFault);
  EXPECT_THROW(fake.stop(), DeviceFault);
  pass(51.0);
  EXPECT_NO_THROW(fake.read_state());
}

TEST_F(FakeSliderTest, AlarmHoldsUntilItIsReset) {
  FakeSlider fake = slider("alarm_code: 9\nfaults: [{kind: alarm, at_mm: 20}]");
  fake.start_move(at(100.0), {100.0, 200.0});
  pass(700.0);
  EXPECT_EQ(fake.read_state().alarm_code, 9);
  const double here = fake.true_position_mm();
  fake.start_move(at(50.0), {100.0, 200.0});
  pass(1000.0);
  EXPECT_EQ(fake.true_position_mm(), here);
  fake.reset_alarm();
  EXPECT_FALSE(fake.read_state().alarm);
}

TEST_F(FakeSliderTest, MistakesInItsConfigurationAreNamed) {
  EXPECT_THROW(slider("speed: 3"), UsageError);
  EXPECT_THROW(slider("faults: [{kind: fire, at_ms: 1}]"), UsageError);
  EXPECT_THROW(slider("faults: [{kind: stall}]"), UsageError);
}

}  // namespace
}  // namespace raywalk::capture
