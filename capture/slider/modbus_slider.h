// A slider whose drive is controlled by Modbus.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "capture/base/clock.h"
#include "capture/slider/modbus_link.h"
#include "capture/slider/register_map.h"
#include "capture/slider/slider_config.h"
#include "capture/slider/slider_state.h"
#include "capture/slider/soft_limits.h"

namespace raywalk::capture {

// Every call is an exchange with the drive, with retries, and throws DeviceFault kNoContact or
// kWrongDevice if it fails. No call waits for the end of a motion.
class ModbusSlider {
 public:
  // `tries`: maximum number of writes of one command, at least 1.
  ModbusSlider(std::unique_ptr<RegisterLink> link, RegisterMap map, int tries);

  // Drive and address, for messages: "leadshine-pr0, unit 1 at /dev/ttyUSB0".
  std::string description() const;
  // Throws kWrongDevice if the identity register of the map holds another value (checked each time
  // the connection has been opened), or if two consecutive readings are impossible: a status word
  // of all ones, or a position beyond any rail.
  SliderState read_state();
  // These throw kNoContact if the drive has not started to execute the command after `tries`
  // unanswered writes. Homing goes towards the home switch, which becomes 0 mm. start_move throws
  // UsageError if the target or the profile does not fit the drive's registers.
  void start_homing();
  void start_move(SafePosition target, const MotionProfile& profile);
  // Decelerates to a stop; harmless at rest.
  void stop();

 private:
  struct Reading {
    std::uint16_t status = 0;
    double position_mm = 0.0;
    double swapped_mm = 0.0;  // the position in the other order of words

    bool is_possible() const;
  };

  RegisterKind state_kind() const;
  Reading read_registers();
  Reading read_plausible();
  SliderState state_of(const Reading& reading);
  bool is_identified() const;
  void check_identity();
  void write_until_executed(const RegisterWrite& write, std::span<const std::uint16_t> words);
  void write_until_answered(const RegisterWrite& write);
  bool has_begun();
  [[noreturn]] void fail_unanswered(const RegisterWrite& write) const;

  std::unique_ptr<RegisterLink> link_;
  RegisterMap map_;
  int tries_;
  int identified_opening_ = 0;  // RegisterLink::openings() when the identity was last checked
  double last_position_mm_ = 0.0;
};

// A slider over RTU or TCP, as configured; the connection is opened at the first exchange. Throws
// UsageError for a register map that cannot be read, or impossible connection settings. The clock
// must outlive the slider.
std::unique_ptr<ModbusSlider> open_slider(const SliderConfig& config, Clock* clock);

}  // namespace raywalk::capture
