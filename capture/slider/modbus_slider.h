// A slider whose drive speaks Modbus.
#pragma once

#include <memory>
#include <string>

#include "capture/base/clock.h"
#include "capture/slider/register_link.h"
#include "capture/slider/register_map.h"
#include "capture/slider/slider.h"
#include "capture/slider/slider_config.h"

namespace raywalk::capture {

// Beyond what Slider says: read_state throws kWrongDevice where the identity register of the map
// holds another value (checked whenever the connection has been opened), or where the drive twice
// in a row reads as no drive does: a status word of all ones, a position beyond any rail.
// start_move throws UsageError where the target or the profile does not fit the drive's registers.
// start_homing, start_move and reset_alarm throw kNoContact where, after `tries` writes without an
// answer, the drive has not begun to do what it was told.
class ModbusSlider final : public Slider {
 public:
  // `tries`: how often one command is written at most, at least 1.
  ModbusSlider(std::unique_ptr<RegisterLink> link, RegisterMap map, int tries);

  std::string description() const override;
  SliderState read_state() override;
  void start_homing() override;
  void start_move(SafePosition target, const MotionProfile& profile) override;
  void stop() override;
  void reset_alarm() override;

 private:
  struct Reading {
    std::uint16_t status = 0;
    double position_mm = 0.0;
  };

  RegisterKind state_kind() const;
  Reading read_registers();
  Reading read_plausible();
  SliderState state_of(const Reading& reading);
  bool is_identified() const;
  void check_identity();
  void write_until_taken(const RegisterWrite& write, std::span<const std::uint16_t> words);
  void write_until_answered(const RegisterWrite& write);
  bool has_begun();
  [[noreturn]] void fail_unanswered(const RegisterWrite& write) const;

  std::unique_ptr<RegisterLink> link_;
  RegisterMap map_;
  int tries_;
  int identified_opening_ = 0;  // the opening of the connection in which identity was checked
  double last_position_mm_ = 0.0;
};

// By the configuration, over RTU or TCP; opens nothing until the first exchange. Throws UsageError
// for a register map that cannot be read, or connection settings that cannot be. The clock has to
// outlive the slider.
std::unique_ptr<Slider> make_modbus_slider(const SliderConfig& config, Clock* clock);

}  // namespace raywalk::capture
