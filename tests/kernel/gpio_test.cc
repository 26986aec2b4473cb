// The shutter on GPIO lines of the kernel's gpio-sim. Needs a gpio-sim device "camera" in configfs
// with one bank, "bank0", of 8 lines; the last test removes it.
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "capture/base/clock.h"
#include "capture/base/test_fault.h"
#include "capture/camera/gpio_camera.h"
#include "tests/kernel/require.h"

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;

constexpr int kFocusLine = 0;
constexpr int kShutterLine = 1;
constexpr int kBusyLine = 2;
const std::string kDevice = "/sys/kernel/config/gpio-sim/camera";
constexpr auto kUntilBusy = milliseconds(30);
constexpr auto kBusy = milliseconds(300);

std::string read_word(const std::string& file) {
  std::string word;
  require(static_cast<bool>(std::ifstream(file) >> word), "cannot read " + file);
  return word;
}

void write_word(const std::string& file, const std::string& word) {
  std::ofstream out(file);
  out << word << std::flush;
  require(static_cast<bool>(out), "cannot write " + file);
}

SteadyTime now() { return std::chrono::steady_clock::now(); }

// The simulated side of gpio-sim's lines. Levels are those of the wire: true is high.
// (Documentation/admin-guide/gpio/gpio-sim.rst)
class GpioSim {
 public:
  // The device "camera" of configfs. Throws if it does not exist.
  GpioSim() : chip_(read_word(kDevice + "/bank0/chip_name")) {
    lines_ =
        "/sys/devices/platform/" + read_word(kDevice + "/dev_name") + "/" + chip_ + "/sim_gpio";
  }

  // Its name in /dev.
  const std::string& chip() const { return chip_; }
  bool level(int line) const { return read_word(lines_ + std::to_string(line) + "/value") == "1"; }
  void pull(int line, bool up) const {
    write_word(lines_ + std::to_string(line) + "/pull", up ? "pull-up" : "pull-down");
  }
  // Removes the chip even while it is in use.
  void unplug() const { write_word(kDevice + "/live", "0"); }

 private:
  std::string chip_;
  std::string lines_;  // sysfs directory of the lines
};

// Times of one press as seen by the camera; SteadyTime{} if it did not occur.
struct SeenPress {
  SteadyTime focused{};
  SteadyTime pressed{};
  SteadyTime released{};
  SteadyTime unfocused{};   // end of the half-press
  SteadyTime busy_from{};   // just before the busy line rose
  SteadyTime busy_until{};  // just before it fell
};

// A simulated camera: monitors the focus and shutter lines and drives the busy line, in its own
// thread.
class WiredCamera {
 public:
  WiredCamera(const GpioSim& lines, bool active_low) : lines_(lines), active_low_(active_low) {
    lines_.pull(kBusyLine, false);
    thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  }
  // Leaves the busy line low.
  ~WiredCamera() {
    thread_.request_stop();
    thread_.join();
    lines_.pull(kBusyLine, false);
  }
  WiredCamera(const WiredCamera&) = delete;
  WiredCamera& operator=(const WiredCamera&) = delete;

  std::vector<SeenPress> presses() {
    const std::lock_guard lock(mutex_);
    return presses_;
  }

 private:
  void work(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      {
        const std::lock_guard lock(mutex_);
        look();
        if (!presses_.empty()) answer();
      }
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  }
  // Focus is read first: as the shutter is released before the focus, a shutter read as pressed
  // after the focus was read as released has been pressed without it.
  void look() {
    const bool focused = lines_.level(kFocusLine) != active_low_;
    const bool pressed = lines_.level(kShutterLine) != active_low_;
    const bool begins = (focused && !focused_) || (pressed && !pressed_ && !focused);
    if (begins) presses_.emplace_back();
    if (focused && !focused_) presses_.back().focused = now();
    if (pressed && !pressed_) presses_.back().pressed = now();
    if (!pressed && pressed_) presses_.back().released = now();
    if (!focused && focused_) presses_.back().unfocused = now();
    focused_ = focused;
    pressed_ = pressed;
  }
  void answer() {
    SeenPress& press = presses_.back();
    const SteadyTime never{};
    if (press.pressed != never && press.busy_from == never && now() >= press.pressed + kUntilBusy) {
      press.busy_from = now();
      lines_.pull(kBusyLine, true);
    }
    if (press.busy_from != never && press.busy_until == never && now() >= press.busy_from + kBusy) {
      press.busy_until = now();
      lines_.pull(kBusyLine, false);
    }
  }

  const GpioSim& lines_;
  bool active_low_;
  bool focused_ = false;
  bool pressed_ = false;
  std::mutex mutex_;
  std::vector<SeenPress> presses_;
  std::jthread thread_;  // last, as it uses the other members
};

// The simulated camera polls about every half millisecond, so a measured span may be too short by
// the delay of its start.
bool lasts(SteadyTime from, SteadyTime to, double ms) {
  return from != SteadyTime{} && ms_from_duration(to - from) > 0.8 * ms;
}

void expect_press(const SeenPress& press, const TriggerConfig& config) {
  EXPECT_TRUE(lasts(press.focused, press.pressed, config.focus_ms)) << "no or a short half-press";
  EXPECT_TRUE(lasts(press.pressed, press.released, config.pulse_ms)) << "a short pulse";
  EXPECT_GE(press.unfocused, press.released) << "focus was released before the shutter";
}

class GpioSimTest : public ::testing::Test {
 protected:
  GpioCamera wired_camera() { return {config, open_gpio_chip(config.chip), &clock}; }
  void expect_both_lines(bool level) const {
    EXPECT_EQ(lines.level(kShutterLine), level);
    EXPECT_EQ(lines.level(kFocusLine), level);
  }

  const GpioSim lines;
  SystemClock clock;
  TriggerConfig config{.chip = lines.chip(),
                       .focus_line = kFocusLine,
                       .shutter_line = kShutterLine,
                       .busy_line = kBusyLine,
                       .focus_ms = 200.0,
                       .pulse_ms = 100.0};
};

TEST_F(GpioSimTest, PressesThreeTimesAndWaitsWhileTheCameraIsBusy) {
  WiredCamera far_side(lines, false);
  GpioCamera camera = wired_camera();
  camera.prepare({.bracket_ev = {-1.0, 0.0, 1.0}}, "");
  EXPECT_EQ(camera.report().state, "idle");
  camera.shoot(clock.now());
  const std::vector<SeenPress> presses = far_side.presses();
  ASSERT_EQ(presses.size(), 3U);
  for (const SeenPress& press : presses) expect_press(press, config);
  for (std::size_t i = 1; i < presses.size(); ++i) {
    EXPECT_GE(presses[i].focused, presses[i - 1].busy_until);
  }
  expect_both_lines(false);
}

TEST_F(GpioSimTest, ExposureTimeIsTheKernelsStampOfTheBusyEdge) {
  WiredCamera far_side(lines, false);
  const Shot shot = wired_camera().shoot(clock.now());
  const SteadyTime done = clock.now();
  const std::vector<SeenPress> presses = far_side.presses();
  ASSERT_EQ(presses.size(), 1U);
  // The two clocks are read one after the other, between which the machine may pause.
  constexpr auto kApart = milliseconds(1);
  EXPECT_LE(shot.triggered_at, wall_time_of(clock, presses[0].pressed) + kApart);
  EXPECT_GE(shot.exposed_at, wall_time_of(clock, presses[0].busy_from) - kApart);
  EXPECT_LE(shot.exposed_at, wall_time_of(clock, presses[0].busy_until) + kApart);
  EXPECT_GE(done, presses[0].busy_until);
}

TEST_F(GpioSimTest, ActiveLowOutputsAreHighAtRest) {
  config.active_low = true;
  GpioCamera camera = wired_camera();
  expect_both_lines(true);
  WiredCamera far_side(lines, true);
  camera.shoot(clock.now());
  ASSERT_EQ(far_side.presses().size(), 1U);
  expect_press(far_side.presses()[0], config);
  expect_both_lines(true);
}

TEST_F(GpioSimTest, CameraThatDoesNotReact) {
  config.busy_start_timeout_ms = 300.0;
  GpioCamera camera = wired_camera();
  expect_fault(FaultKind::kMissingPicture, "did not become busy",
               [&] { camera.shoot(clock.now()); });
  expect_both_lines(false);
}

TEST_F(GpioSimTest, CameraThatStaysBusy) {
  config.busy_end_timeout_ms = 300.0;
  lines.pull(kBusyLine, true);
  GpioCamera camera = wired_camera();
  EXPECT_EQ(camera.report().state, "busy");
  expect_fault(FaultKind::kBusy, "stayed busy", [&] { camera.shoot(clock.now()); });
  lines.pull(kBusyLine, false);
  EXPECT_EQ(camera.report().state, "idle");
  expect_both_lines(false);
}

TEST_F(GpioSimTest, LinesThatAnotherProgramHolds) {
  const GpioCamera owner = wired_camera();
  expect_fault(FaultKind::kNoContact, "in use by 'raywalk-capture'", [&] { wired_camera(); });
}

TEST_F(GpioSimTest, LinesAndChipsThatDoNotExist) {
  config.shutter_line = 8;
  expect_fault(FaultKind::kWrongDevice, "there is no line 8", [&] { wired_camera(); });
  expect_fault(FaultKind::kNoContact, "no GPIO chip", [] { open_gpio_chip("gpiochip99"); });
  expect_fault(FaultKind::kWrongDevice, "is not a GPIO chip", [] { open_gpio_chip("/dev/null"); });
}

// Last, as the chip stays away.
TEST_F(GpioSimTest, ChipUnpluggedWhileInUse) {
  GpioCamera camera = wired_camera();
  lines.unplug();
  expect_fault(FaultKind::kNoContact, "no longer answers", [&] { camera.shoot(clock.now()); });
}

}  // namespace
}  // namespace raywalk::capture
