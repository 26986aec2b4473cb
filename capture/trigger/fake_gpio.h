// For tests: an implementation of gpio_lines.h with a simulated chip and camera. Time is that of a
// Clock; with a ManualClock nothing waits.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "capture/trigger/gpio_lines.h"

namespace raywalk::capture {

enum class FakeGpioCamera { kGood, kNeverBusy, kBusyForEver };

struct FakeGpioSettings {
  int lines = 8;
  int shutter_line = 1;
  int busy_line = 2;
  bool shutter_active_low = false;  // as wired, independent of the program's settings
  bool busy_active_low = false;
  double busy_delay_ms = 30.0;  // from the shutter's press to the busy line
  double busy_ms = 400.0;
  bool films = false;  // a press starts a film, the next one stops it
  FakeGpioCamera camera = FakeGpioCamera::kGood;
  int bad_press = 0;               // the only press, from 1, with the camera's fault; 0: all
  int open_error = 0;              // errno of opening the chip
  int taken_line = -1;             // owned by another program
  std::string taken_by = "other";  // name of that program
  int gone_after_changes = -1;  // the chip is removed after this many changes of outputs; -1: never
};

// A change of an output's voltage.
struct GpioLevelChange {
  int line = 0;
  bool high = false;
  SteadyTime time{};
  friend bool operator==(const GpioLevelChange&, const GpioLevelChange&) = default;
};

// The chip, the wiring and the camera. Must outlive the chips that it opens.
class FakeGpio {
 public:
  FakeGpio(FakeGpioSettings settings, Clock* clock);

  // As open_gpio_chip; throws DeviceFault as configured.
  std::unique_ptr<GpioChip> open();

  // Every change of the outputs so far, in order.
  const std::vector<GpioLevelChange>& changes() const { return changes_; }
  // Presses of the shutter, including those that a busy camera ignored.
  int presses() const { return presses_; }
  bool is_owned(int line) const { return owned_.at(static_cast<std::size_t>(line)); }

 private:
  friend class FakeGpioChip;
  friend class FakeGpioOutput;
  friend class FakeGpioInput;

  void take(const GpioLine& line);
  void give_back(int line) { owned_.at(static_cast<std::size_t>(line)) = false; }
  void set_voltage(int line, bool high);
  void press_camera();
  void plan_busy();
  bool misbehaves(FakeGpioCamera how) const;
  // Applies the changes of the busy line that are due.
  void catch_up();

  FakeGpioSettings settings_;
  Clock* clock_;
  std::vector<bool> owned_;
  std::map<int, bool> high_;  // outputs that were ever driven
  std::vector<GpioLevelChange> changes_;
  int presses_ = 0;
  bool filming_ = false;
  bool busy_ = false;
  std::deque<GpioEdge> coming_;  // future edges of the busy line, in order of time
  std::deque<GpioEdge> queued_;  // in the kernel's queue
};

}  // namespace raywalk::capture
