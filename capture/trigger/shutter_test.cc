#include "capture/trigger/shutter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <csignal>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/trigger/fake_gpio.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

SteadyTime at_ms(double ms) { return SteadyTime{duration_from_ms(ms)}; }

TriggerConfig wired() {
  TriggerConfig config;
  config.focus_line = 0;
  config.shutter_line = 1;
  config.busy_line = 2;
  return config;
}

// A shutter on the fake chip of these settings.
struct Rig {
  explicit Rig(const FakeGpioSettings& settings, const TriggerConfig& config = wired())
      : gpio(settings, &clock), shutter(config, gpio.open(), &clock) {}

  ManualClock clock;
  FakeGpio gpio;
  Shutter shutter;
};

bool is_let_go(const FakeGpio& gpio, bool active_low = false) {
  std::map<int, bool> high;
  for (const GpioLevelChange& change : gpio.changes()) high[change.line] = change.high;
  return high[0] == active_low && high[1] == active_low;
}

TEST(Shutter, PressesHalfThenFullyThenReleases) {
  Rig rig({.busy_delay_ms = 30, .busy_ms = 400});
  const ShutterTimes times = rig.shutter.take_picture();
  EXPECT_THAT(
      rig.gpio.changes(),
      ElementsAre(GpioLevelChange{0, true, at_ms(0)}, GpioLevelChange{1, true, at_ms(300)},
                  GpioLevelChange{1, false, at_ms(400)}, GpioLevelChange{0, false, at_ms(400)}));
  EXPECT_EQ(times.pressed, at_ms(300));
  EXPECT_EQ(times.exposed, at_ms(330));
  EXPECT_EQ(times.done, at_ms(730));
}

TEST(Shutter, ActiveLowLinesAreHighBetweenPresses) {
  TriggerConfig config = wired();
  config.focus_line = -1;
  config.active_low = true;
  config.busy_active_low = true;
  Rig rig({.shutter_active_low = true, .busy_active_low = true}, config);
  EXPECT_EQ(rig.shutter.is_busy(), false);
  rig.shutter.take_picture();
  EXPECT_THAT(rig.gpio.changes(), ElementsAre(GpioLevelChange{1, false, at_ms(0)},
                                              GpioLevelChange{1, true, at_ms(100)}));
}

TEST(Shutter, SeesABusyPulseThatEndsDuringThePress) {
  Rig rig({.busy_delay_ms = 10, .busy_ms = 1});
  const ShutterTimes times = rig.shutter.take_picture();
  EXPECT_EQ(times.exposed, at_ms(310));
  EXPECT_EQ(times.done, at_ms(400));
}

TEST(Shutter, HoldsWhereThereIsNoBusyLine) {
  TriggerConfig config = wired();
  config.busy_line = -1;
  Rig rig({}, config);
  EXPECT_EQ(rig.shutter.is_busy(), std::nullopt);
  const ShutterTimes times = rig.shutter.take_picture();
  EXPECT_EQ(times.exposed, times.pressed);
  EXPECT_EQ(times.done, at_ms(2400));
}

TEST(Shutter, EveryPictureIsOnePress) {
  Rig rig({});
  for (int i = 0; i < 100; ++i) rig.shutter.take_picture();
  EXPECT_EQ(rig.gpio.presses(), 100);
}

TEST(Shutter, WaitsForACameraThatIsStillBusy) {
  Rig rig({.busy_delay_ms = 0, .busy_ms = 5000});
  rig.shutter.start_film();  // returns as soon as the camera is busy
  EXPECT_EQ(rig.shutter.is_busy(), true);
  const ShutterTimes times = rig.shutter.take_picture();
  EXPECT_EQ(times.pressed, at_ms(300 + 5000 + 300));
}

TEST(Shutter, CameraThatNeverBecomesBusyTookNoPicture) {
  Rig rig({.camera = FakeGpioCamera::kNeverBusy});
  expect_fault(FaultKind::kMissingPicture, "did not become busy within 2000 ms of the shutter",
               [&] { rig.shutter.take_picture(); });
  EXPECT_EQ(rig.clock.now(), at_ms(300 + 2000));
  EXPECT_TRUE(is_let_go(rig.gpio));
}

TEST(Shutter, PressAfterAMissedOneTakesItsPicture) {
  Rig rig({.camera = FakeGpioCamera::kNeverBusy, .bad_press = 1});
  EXPECT_THROW(rig.shutter.take_picture(), DeviceFault);
  EXPECT_NO_THROW(rig.shutter.take_picture());
}

TEST(Shutter, CameraThatStaysBusyIsAFault) {
  Rig rig({.camera = FakeGpioCamera::kBusyForEver});
  expect_fault(FaultKind::kBusy, "stayed busy for 30000 ms after the shutter",
               [&] { rig.shutter.take_picture(); });
  expect_fault(FaultKind::kBusy, "before the shutter", [&] { rig.shutter.take_picture(); });
  EXPECT_EQ(rig.gpio.presses(), 1) << "pressed although the camera was busy";
  EXPECT_TRUE(is_let_go(rig.gpio));
}

TEST(Shutter, ChipRemovedDuringAPressIsNoContact) {
  Rig rig({.gone_after_changes = 2});
  expect_fault(FaultKind::kNoContact, "line 1 of /dev/gpiochip-fake no longer answers",
               [&] { rig.shutter.take_picture(); });
}

TEST(Shutter, ToggledFilmIsAPressAtEachEnd) {
  Rig rig({.busy_delay_ms = 40, .films = true});
  const ShutterTimes start = rig.shutter.start_film();
  EXPECT_EQ(start.exposed - start.pressed, duration_from_ms(40));
  rig.clock.sleep(std::chrono::seconds(60));
  EXPECT_EQ(rig.shutter.is_busy(), true);
  rig.shutter.stop_film();
  EXPECT_EQ(rig.shutter.is_busy(), false);
  EXPECT_EQ(rig.gpio.presses(), 2);
}

TEST(Shutter, FilmThatDoesNotStartOrStopIsAFault) {
  Rig dead({.films = true, .camera = FakeGpioCamera::kNeverBusy});
  EXPECT_EQ(fault_of([&] { dead.shutter.start_film(); }).kind(), FaultKind::kMissingPicture);
  Rig endless({.films = true, .camera = FakeGpioCamera::kBusyForEver});
  endless.shutter.start_film();
  EXPECT_EQ(fault_of([&] { endless.shutter.stop_film(); }).kind(), FaultKind::kBusy);
}

TEST(Shutter, OwnsItsLinesUntilDestroyed) {
  ManualClock clock;
  FakeGpio gpio(FakeGpioSettings{}, &clock);
  {
    const Shutter shutter(wired(), gpio.open(), &clock);
    EXPECT_TRUE(gpio.is_owned(0) && gpio.is_owned(1) && gpio.is_owned(2));
    const DeviceFault fault = fault_of([&] { const Shutter second(wired(), gpio.open(), &clock); });
    EXPECT_THAT(fault.what(), HasSubstr("in use by 'raywalk-capture'"));
  }
  EXPECT_FALSE(gpio.is_owned(0) || gpio.is_owned(1) || gpio.is_owned(2));
}

TEST(Shutter, NamesTheLineThatCannotBeRequested) {
  expect_fault(FaultKind::kNoContact, "line 2 of /dev/gpiochip-fake is in use by 'lirc'",
               [] { Rig rig({.taken_line = 2, .taken_by = "lirc"}); });
  TriggerConfig config = wired();
  config.focus_line = 8;
  expect_fault(FaultKind::kWrongDevice, "no line 8 of /dev/gpiochip-fake, which has 8 lines",
               [&] { Rig rig({.lines = 8}, config); });
}

TEST(Shutter, SaysWhyTheChipCannotBeOpened) {
  EXPECT_EQ(fault_of([] { Rig rig({.open_error = ENOENT}); }).kind(), FaultKind::kNoContact);
  EXPECT_THAT(fault_of([] { Rig rig({.open_error = EACCES}); }).what(), HasSubstr("no permission"));
  EXPECT_EQ(fault_of([] { Rig rig({.open_error = ENOTTY}); }).kind(), FaultKind::kWrongDevice);
}

TEST(Shutter, NeedsAShutterLine) {
  TriggerConfig config = wired();
  config.shutter_line = -1;
  EXPECT_THROW(Rig({}, config), UsageError);
}

// Raises SIGINT once the lines reach a state, as an operator might at any moment.
class InterruptingClock final : public Clock {
 public:
  explicit InterruptingClock(SteadyTime when) : when_(when) {}
  SteadyTime now() const override { return clock_.now(); }
  WallTime wall_now() const override { return clock_.wall_now(); }
  void sleep(Duration duration) override {
    clock_.sleep(duration);
    if (clock_.now() >= when_ && !interrupt_requested()) std::raise(SIGINT);
  }

 private:
  ManualClock clock_;
  SteadyTime when_;
};

// Exit code: 10 times the changes of lines before the interruption, plus 1 if all are released.
void interrupt_picture_at(double ms) {
  install_interrupt_handlers();
  InterruptingClock clock(at_ms(ms));
  FakeGpio gpio({.camera = FakeGpioCamera::kBusyForEver}, &clock);
  Shutter shutter(wired(), gpio.open(), &clock);
  try {
    shutter.take_picture();
  } catch (const Interrupted&) {
    std::exit(10 * static_cast<int>(gpio.changes().size()) + (is_let_go(gpio) ? 1 : 0));
  }
  std::exit(0);
}

class ShutterDeathTest : public testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(ShutterDeathTest, InterruptAtTheHalfPressTakesNoPicture) {
  EXPECT_EXIT(interrupt_picture_at(100), testing::ExitedWithCode(21), "");
  EXPECT_EXIT(interrupt_picture_at(300), testing::ExitedWithCode(21), "");
}

TEST_F(ShutterDeathTest, InterruptDuringThePressOrAfterItReleasesTheLines) {
  EXPECT_EXIT(interrupt_picture_at(350), testing::ExitedWithCode(41), "");
  EXPECT_EXIT(interrupt_picture_at(5000), testing::ExitedWithCode(41), "");
}

}  // namespace
}  // namespace raywalk::capture
