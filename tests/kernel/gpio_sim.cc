#include "tests/kernel/gpio_sim.h"

#include <chrono>
#include <fstream>

#include "tests/kernel/check_report.h"

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;

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

}  // namespace

GpioSim::GpioSim() : chip_(read_word(kDevice + "/bank0/chip_name")) {
  lines_ = "/sys/devices/platform/" + read_word(kDevice + "/dev_name") + "/" + chip_ + "/sim_gpio";
}

bool GpioSim::level(int line) const {
  return read_word(lines_ + std::to_string(line) + "/value") == "1";
}

void GpioSim::pull(int line, bool up) const {
  write_word(lines_ + std::to_string(line) + "/pull", up ? "pull-up" : "pull-down");
}

void GpioSim::unplug() const { write_word(kDevice + "/live", "0"); }

WiredCamera::WiredCamera(const GpioSim& lines, bool active_low)
    : lines_(lines), active_low_(active_low) {
  lines_.pull(kBusyLine, false);
  thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

WiredCamera::~WiredCamera() {
  thread_.request_stop();
  thread_.join();
  lines_.pull(kBusyLine, false);
}

std::vector<SeenPress> WiredCamera::presses() {
  const std::lock_guard lock(mutex_);
  return presses_;
}

void WiredCamera::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    {
      const std::lock_guard lock(mutex_);
      look();
      if (!presses_.empty()) answer();
    }
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

// Focus is read first: as the shutter is released before the focus, a shutter read as pressed after
// the focus was read as released has been pressed without it.
void WiredCamera::look() {
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

void WiredCamera::answer() {
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

}  // namespace raywalk::capture
