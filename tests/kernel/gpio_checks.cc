#include <chrono>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "capture/base/clock.h"
#include "capture/camera/gpio_camera.h"
#include "tests/kernel/check_report.h"

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
  // The device "camera" of configfs. Throws CheckFailure if it does not exist.
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

TriggerConfig wired(const GpioSim& lines) {
  TriggerConfig config;
  config.chip = lines.chip();
  config.focus_line = kFocusLine;
  config.shutter_line = kShutterLine;
  config.busy_line = kBusyLine;
  config.focus_ms = 200.0;
  config.pulse_ms = 100.0;
  return config;
}

void require_released(const GpioSim& lines) {
  require(!lines.level(kShutterLine), "the shutter line stays active");
  require(!lines.level(kFocusLine), "the focus line stays active");
}

// The simulated camera polls about every half millisecond, so a measured span may be too short by
// the delay of its start.
bool lasts(SteadyTime from, SteadyTime to, double ms) {
  return from != SteadyTime{} && ms_from_duration(to - from) > 0.8 * ms;
}

void require_press(const SeenPress& press, const TriggerConfig& config) {
  require(lasts(press.focused, press.pressed, config.focus_ms), "half-press missing or too short");
  require(lasts(press.pressed, press.released, config.pulse_ms), "shutter pulse too short");
  require(press.unfocused >= press.released, "focus released before the shutter");
}

void check_three_presses(const GpioSim& lines) {
  SystemClock clock;
  WiredCamera far_side(lines, false);
  const TriggerConfig config = wired(lines);
  GpioCamera camera(config, open_gpio_chip(config.chip), &clock);
  ExposureSettings bracket;
  bracket.bracket_ev = {-1.0, 0.0, 1.0};
  camera.prepare(bracket, "");
  require(camera.report().state == "idle", "not idle at first: " + camera.report().state);
  camera.shoot(clock.now());
  const std::vector<SeenPress> presses = far_side.presses();
  require_near(static_cast<double>(presses.size()), 3.0, 0.0, "number of presses");
  for (const SeenPress& press : presses) require_press(press, config);
  for (std::size_t i = 1; i < presses.size(); ++i) {
    require(presses[i].focused >= presses[i - 1].busy_until, "pressed while the camera was busy");
  }
  require_released(lines);
}

void check_times(const GpioSim& lines) {
  SystemClock clock;
  WiredCamera far_side(lines, false);
  const TriggerConfig config = wired(lines);
  GpioCamera camera(config, open_gpio_chip(config.chip), &clock);
  const Shot shot = camera.shoot(clock.now());
  const SteadyTime done = clock.now();
  const std::vector<SeenPress> presses = far_side.presses();
  require(presses.size() == 1, "not one press");
  // The two clocks are read one after the other, between which the machine may pause.
  constexpr auto kApart = std::chrono::milliseconds(1);
  require(shot.triggered_at <= wall_time_of(clock, presses[0].pressed) + kApart,
          "pressed later than the line rose");
  require(shot.exposed_at >= wall_time_of(clock, presses[0].busy_from) - kApart &&
              shot.exposed_at <= wall_time_of(clock, presses[0].busy_until) + kApart,
          "the kernel's stamp of the busy edge is not of this clock");
  require(done >= presses[0].busy_until, "done before the camera was");
}

void check_active_low(const GpioSim& lines) {
  SystemClock clock;
  TriggerConfig config = wired(lines);
  config.active_low = true;
  GpioCamera camera(config, open_gpio_chip(config.chip), &clock);
  require(lines.level(kShutterLine) && lines.level(kFocusLine), "not high at rest");
  WiredCamera far_side(lines, true);
  camera.shoot(clock.now());
  require(far_side.presses().size() == 1, "not one press");
  require_press(far_side.presses()[0], config);
  require(lines.level(kShutterLine) && lines.level(kFocusLine), "not high afterwards");
}

void check_silent_camera(const GpioSim& lines) {
  SystemClock clock;
  TriggerConfig config = wired(lines);
  config.busy_start_timeout_ms = 300.0;
  GpioCamera camera(config, open_gpio_chip(config.chip), &clock);
  require_fault(FaultKind::kMissingPicture, "did not become busy",
                [&] { camera.shoot(clock.now()); });
  require_released(lines);
}

void check_busy_camera(const GpioSim& lines) {
  SystemClock clock;
  TriggerConfig config = wired(lines);
  config.busy_end_timeout_ms = 300.0;
  lines.pull(kBusyLine, true);
  GpioCamera camera(config, open_gpio_chip(config.chip), &clock);
  require(camera.report().state == "busy", "not reported busy");
  require_fault(FaultKind::kBusy, "stayed busy", [&] { camera.shoot(clock.now()); });
  lines.pull(kBusyLine, false);
  require(camera.report().state == "idle", "not reported idle again");
  require_released(lines);
}

void check_second_owner(const GpioSim& lines) {
  SystemClock clock;
  const TriggerConfig config = wired(lines);
  const GpioCamera owner(config, open_gpio_chip(config.chip), &clock);
  require_fault(FaultKind::kNoContact, "in use by 'raywalk-capture'",
                [&] { const GpioCamera other(config, open_gpio_chip(config.chip), &clock); });
}

void check_wrong_lines(const GpioSim& lines) {
  SystemClock clock;
  TriggerConfig config = wired(lines);
  config.shutter_line = 8;
  require_fault(FaultKind::kWrongDevice, "there is no line 8",
                [&] { const GpioCamera camera(config, open_gpio_chip(config.chip), &clock); });
  require_fault(FaultKind::kNoContact, "no GPIO chip", [] { open_gpio_chip("gpiochip99"); });
  require_fault(FaultKind::kWrongDevice, "is not a GPIO chip", [] { open_gpio_chip("/dev/null"); });
}

void check_unplugged_chip(const GpioSim& lines) {
  SystemClock clock;
  const TriggerConfig config = wired(lines);
  GpioCamera camera(config, open_gpio_chip(config.chip), &clock);
  lines.unplug();
  require_fault(FaultKind::kNoContact, "no longer answers", [&] { camera.shoot(clock.now()); });
}

}  // namespace

void check_gpio(CheckReport* report) {
  const GpioSim lines;
  report->run("gpio: three presses, each half-press, press, release, and wait while busy",
              [&] { check_three_presses(lines); });
  report->run("gpio: exposure time is the kernel's stamp of the busy edge",
              [&] { check_times(lines); });
  report->run("gpio: active-low outputs", [&] { check_active_low(lines); });
  report->run("gpio: camera that does not react", [&] { check_silent_camera(lines); });
  report->run("gpio: camera that stays busy", [&] { check_busy_camera(lines); });
  report->run("gpio: lines that another program holds", [&] { check_second_owner(lines); });
  report->run("gpio: lines and chips that do not exist", [&] { check_wrong_lines(lines); });
  report->run("gpio: chip unplugged while in use", [&] { check_unplugged_chip(lines); });
}

}  // namespace raywalk::capture
