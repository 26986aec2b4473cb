#include "capture/camera/gpio_camera.h"

#include <gtest/gtest.h>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/trigger/fake_gpio.h"

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;

TriggerConfig wired() {
  TriggerConfig config;
  config.shutter_line = 1;
  config.busy_line = 2;
  return config;
}

struct CableRig {
  explicit CableRig(const FakeGpioSettings& settings, const TriggerConfig& config = wired())
      : gpio(settings, &clock), camera(config, gpio.open(), &clock) {}

  ManualClock clock;
  FakeGpio gpio;
  GpioCamera camera;
};

ExposureSettings bracket(std::vector<double> ev) {
  ExposureSettings settings;
  settings.bracket_ev = std::move(ev);
  return settings;
}

TEST(GpioCamera, ShotIsOnePressAndBringsNoPicture) {
  CableRig rig({.busy_delay_ms = 30, .busy_ms = 400});
  const WallTime start = rig.clock.wall_now();
  rig.camera.prepare({}, "");
  const Shot shot = rig.camera.shoot(rig.clock.now());
  EXPECT_TRUE(rig.camera.keeps_pictures());
  EXPECT_TRUE(shot.pictures.empty());
  EXPECT_EQ(shot.triggered_at, start);
  EXPECT_EQ(shot.exposed_at, start + milliseconds(30));
  EXPECT_DOUBLE_EQ(shot.exposing_ms, 430.0);
  EXPECT_EQ(rig.gpio.presses(), 1);
}

TEST(GpioCamera, NeverPressesBeforeTheCarriageSettled) {
  CableRig rig({});
  const SteadyTime settled = rig.clock.now() + milliseconds(700);
  rig.camera.shoot(settled);
  EXPECT_EQ(rig.gpio.changes().front().time, settled);
}

TEST(GpioCamera, BracketIsAPressPerExposure) {
  CableRig rig({});
  rig.camera.prepare(bracket({-2.0, 0.0, 2.0}), "");
  rig.camera.shoot(rig.clock.now());
  rig.camera.shoot(rig.clock.now());
  EXPECT_EQ(rig.gpio.presses(), 6);
}

TEST(GpioCamera, BracketIsOnePressIfTheCameraTakesAll) {
  TriggerConfig config = wired();
  config.press_per_exposure = false;
  CableRig rig({}, config);
  rig.camera.prepare(bracket({-2.0, 0.0, 2.0}), "");
  rig.camera.shoot(rig.clock.now());
  EXPECT_EQ(rig.gpio.presses(), 1);
}

TEST(GpioCamera, RefusesExposureSettings) {
  CableRig rig({});
  ExposureSettings settings;
  settings.shutter_s = 0.01;
  EXPECT_THROW(rig.camera.prepare(settings, ""), UsageError);
  EXPECT_EQ(rig.camera.prepare({}, ""), "");
}

TEST(GpioCamera, ReportsItsStateFromTheBusyLine) {
  CableRig rig({.busy_delay_ms = 0, .films = true});
  EXPECT_EQ(rig.camera.report().identity, "camera on line 1 of /dev/gpiochip-fake (fake, 8 lines)");
  EXPECT_EQ(rig.camera.report().state, "idle");
  rig.camera.start_film();
  EXPECT_EQ(rig.camera.report().state, "busy");
  rig.camera.stop_film();
  EXPECT_EQ(rig.camera.report().state, "idle");
  EXPECT_EQ(rig.gpio.presses(), 2);
  TriggerConfig blind = wired();
  blind.busy_line = -1;
  CableRig other({}, blind);
  EXPECT_EQ(other.camera.report().state, "unknown");
}

TEST(GpioCamera, MissedPictureIsWorthAnotherShot) {
  CableRig rig({.camera = FakeGpioCamera::kNeverBusy, .bad_press = 1});
  EXPECT_TRUE(fault_of([&] { rig.camera.shoot(rig.clock.now()); }).is_retryable());
  EXPECT_NO_THROW(rig.camera.shoot(rig.clock.now()));
}

}  // namespace
}  // namespace raywalk::capture
