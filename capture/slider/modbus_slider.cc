#include "capture/slider/modbus_slider.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/base/device_fault.h"

namespace raywalk::capture {
namespace {

// Longer than any rail driven by one motor.
constexpr double kLongestRail_mm = 100000.0;
// The value read from an open data line or an empty register bank.
constexpr std::uint16_t kAllOnes = 0xffff;
// The carriage has started to move once its position differs by more than this from before the
// command. A servo at rest stays within a few steps.
constexpr double kSetOff_mm = 0.05;

bool is_on_a_rail(double position_mm) { return std::abs(position_mm) <= kLongestRail_mm; }

}  // namespace

bool ModbusSlider::Reading::is_possible() const {
  return status != kAllOnes && is_on_a_rail(position_mm);
}

ModbusSlider::ModbusSlider(std::unique_ptr<RegisterLink> link, RegisterMap map, int tries)
    : link_(std::move(link)), map_(std::move(map)), tries_(std::max(tries, 1)) {}

std::string ModbusSlider::description() const { return map_.name + ", " + link_->description(); }

RegisterKind ModbusSlider::state_kind() const {
  return map_.input_registers ? RegisterKind::kInput : RegisterKind::kHolding;
}

SliderState ModbusSlider::read_state() {
  if (!is_identified()) check_identity();
  Reading reading = read_plausible();
  // A connection reopened during the reading may have reached another device.
  if (!is_identified()) {
    check_identity();
    reading = read_plausible();
  }
  last_position_mm_ = reading.position_mm;
  return state_of(reading);
}

// If status and position are adjacent, or the drive reads across gaps, one request reads both: they
// then belong to the same moment, and the reply differs in shape from all others. Otherwise the
// position, two words, has a shape of its own.
ModbusSlider::Reading ModbusSlider::read_registers() {
  const int first = std::min(map_.position_address, map_.status_address);
  const int end = std::max(map_.position_address + 2, map_.status_address + 1);
  const bool side_by_side = end - first == 3;
  std::uint16_t status = 0;
  std::vector<std::uint16_t> position;
  if (map_.one_read || side_by_side) {
    const auto all = link_->read(state_kind(), first, end - first);
    status = all[static_cast<std::size_t>(map_.status_address - first)];
    const auto at = all.begin() + (map_.position_address - first);
    position.assign(at, at + 2);
  } else {
    status = link_->read(state_kind(), map_.status_address, 1).front();
    position = link_->read(state_kind(), map_.position_address, 2);
  }
  return {status, mm_from_words(map_, position[0], position[1]),
          mm_from_words(map_, position[1], position[0])};
}

// One damaged reply in 65536 passes the checksum; a second reading tells it from a wrong device.
ModbusSlider::Reading ModbusSlider::read_plausible() {
  Reading reading = read_registers();
  if (!reading.is_possible()) reading = read_registers();
  if (reading.is_possible()) return reading;
  const bool is_swapped = reading.status != kAllOnes && is_on_a_rail(reading.swapped_mm);
  const std::string remedy =
      is_swapped ? fmt::format(
                       "in the other order its words are {:.3f} mm: if the carriage is "
                       "there, set low_word_first to {} in the register map",
                       reading.swapped_mm, !map_.low_word_first)
                 : "check the register map against the drive's manual";
  throw DeviceFault(
      FaultKind::kWrongDevice,
      fmt::format("{} returns impossible values (status 0x{:04x}, position {:.0f} mm); {}",
                  description(), reading.status, reading.position_mm, remedy));
}

SliderState ModbusSlider::state_of(const Reading& reading) {
  SliderState state;
  state.position_mm = reading.position_mm;
  state.alarm = flag_of(reading.status, map_.alarm).value_or(false);
  state.enabled = flag_of(reading.status, map_.enabled);
  state.homed = flag_of(reading.status, map_.homed);
  state.moving = flag_of(reading.status, map_.moving);
  state.in_position = flag_of(reading.status, map_.in_position);
  state.at_low_limit = flag_of(reading.status, map_.at_low_limit);
  state.at_high_limit = flag_of(reading.status, map_.at_high_limit);
  if (state.alarm && map_.alarm_address >= 0) {
    state.alarm_code = link_->read(state_kind(), map_.alarm_address, 1).front();
  }
  return state;
}

bool ModbusSlider::is_identified() const {
  return map_.identity_address < 0 ||
         (identified_opening_ > 0 && identified_opening_ == link_->openings());
}

void ModbusSlider::check_identity() {
  const int value = link_->read(state_kind(), map_.identity_address, 1).front();
  if (value != map_.identity_value) {
    throw DeviceFault(
        FaultKind::kWrongDevice,
        fmt::format("{} is another device: register 0x{:04x} holds 0x{:04x}, not 0x{:04x}; check "
                    "unit, port and register map",
                    description(), map_.identity_address, value, map_.identity_value));
  }
  identified_opening_ = link_->openings();
}

void ModbusSlider::start_homing() { write_until_executed(map_.home, words_of(map_, map_.home)); }

void ModbusSlider::start_move(SafePosition target, const MotionProfile& profile) {
  const auto words = words_of(map_, map_.move, target.mm(), profile);
  write_until_executed(map_.move, words);
  if (map_.start.exists()) write_until_executed(map_.start, words_of(map_, map_.start));
}

// A stop may be repeated safely and must not wait for readings.
void ModbusSlider::stop() { write_until_answered(map_.stop); }

// An unanswered write may have been executed (observed on a real line after a timeout), so it is
// repeated only after a reading shows that nothing has started. If that reading was too early, the
// repetition is harmless: moves are absolute, and homing starts again.
void ModbusSlider::write_until_executed(const RegisterWrite& write,
                                        std::span<const std::uint16_t> words) {
  for (int written = 0; written < tries_; ++written) {
    if (link_->write(write.address, words) || has_begun()) return;
  }
  fail_unanswered(write);
}

bool ModbusSlider::has_begun() {
  const double before_mm = last_position_mm_;
  const SliderState state = read_state();
  return state.moving.value_or(false) || std::abs(state.position_mm - before_mm) > kSetOff_mm;
}

void ModbusSlider::write_until_answered(const RegisterWrite& write) {
  const auto words = words_of(map_, write);
  for (int written = 0; written < tries_; ++written) {
    if (link_->write(write.address, words)) return;
  }
  fail_unanswered(write);
}

void ModbusSlider::fail_unanswered(const RegisterWrite& write) const {
  throw DeviceFault(
      FaultKind::kNoContact,
      fmt::format("{} does not answer a write to register 0x{:04x} (tries: {}); check "
                  "the drive's power and its cable",
                  description(), write.address, tries_));
}

std::unique_ptr<ModbusSlider> open_slider(const SliderConfig& config, Clock* clock) {
  return std::make_unique<ModbusSlider>(std::make_unique<ModbusLink>(config, clock),
                                        read_register_map(config.register_map), config.tries);
}

}  // namespace raywalk::capture
