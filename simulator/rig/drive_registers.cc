#include "simulator/rig/drive_registers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/error.h"

namespace raywalk::simulator {
namespace {

constexpr int kRegisters = 65536;  // every address

// Saturates to the signed 32 bits of the feedback registers.
std::int32_t saturated_steps(double steps) {
  constexpr double kMin = std::numeric_limits<std::int32_t>::min();
  constexpr double kMax = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::clamp(std::round(steps), kMin, kMax));
}

}  // namespace

DriveRegisters::DriveRegisters(const RegisterMap& map, SimulatedDrive* drive)
    : map_(map),
      drive_(drive),
      mapping_(modbus_mapping_new(0, 0, kRegisters, map.input_registers ? kRegisters : 0)) {
  if (!mapping_) throw Error("no memory for the registers of the simulated drive");
}

std::uint16_t& DriveRegisters::word_at(int address) const {
  return mapping_->tab_registers[address];
}

void DriveRegisters::set_state(int address, int value) const {
  if (address < 0) return;
  const auto word = static_cast<std::uint16_t>(value & 0xffff);
  if (map_.input_registers) {
    mapping_->tab_input_registers[address] = word;
  } else {
    word_at(address) = word;
  }
}

modbus_mapping_t* DriveRegisters::refreshed() {
  const DriveState state = drive_->state();
  const std::int32_t steps = saturated_steps(state.feedback_mm * map_.steps_per_mm);
  set_state(map_.position_address, map_.low_word_first ? steps : steps >> 16);
  set_state(map_.position_address + 1, map_.low_word_first ? steps >> 16 : steps);
  set_state(map_.status_address, status_word(state));
  set_state(map_.alarm_address, state.alarm_code);
  set_state(map_.identity_address, map_.identity_value);
  return mapping_.get();
}

int DriveRegisters::status_word(const DriveState& state) const {
  int word = 0;
  const auto set = [&word](const StatusBit& bit, bool value) {
    if (bit.bit >= 0 && value != bit.active_low) word |= 1 << bit.bit;
  };
  set(map_.alarm, state.alarm);
  set(map_.enabled, state.enabled);
  set(map_.homed, state.homed);
  set(map_.moving, state.moving);
  set(map_.in_position, state.in_position);
  set(map_.at_low_limit, state.at_low_limit);
  set(map_.at_high_limit, state.at_high_limit);
  return word;
}

// Whether the write covered the block and its constants match the map.
bool DriveRegisters::was_written(const RegisterWrite& block, int address, int count) const {
  const auto size = static_cast<int>(block.words.size());
  if (address > block.address || address + count < block.address + size) return false;
  for (int i = 0; i < size; ++i) {
    const BlockWord& word = block.words[static_cast<std::size_t>(i)];
    const bool matches =
        word.meaning != WordMeaning::kConstant || word_at(block.address + i) == word.constant;
    if (!matches) return false;
  }
  return size > 0;
}

bool DriveRegisters::execute(int address, int count) {
  const auto written = [&](const RegisterWrite& block) {
    return was_written(block, address, count);
  };
  if (written(map_.stop)) {
    drive_->stop();
  } else if (written(map_.home)) {
    drive_->home();
  } else if (written(map_.start.exists() ? map_.start : map_.move)) {
    return start_move();
  }
  return true;
}

double DriveRegisters::acceleration_of(std::uint16_t units) const {
  // Some drives take the milliseconds to reach a speed.
  return map_.acceleration_time_to_mm_s > 0.0 ? map_.acceleration_time_to_mm_s / (1e-3 * units)
                                              : units / map_.acceleration_per_mm_s2;
}

std::optional<std::uint16_t> DriveRegisters::word_of_move(WordMeaning meaning) const {
  for (std::size_t i = 0; i < map_.move.words.size(); ++i) {
    if (map_.move.words[i].meaning == meaning) {
      return word_at(map_.move.address + static_cast<int>(i));
    }
  }
  return std::nullopt;
}

// What the block does not hold is the drive's maximum.
bool DriveRegisters::start_move() const {
  using enum WordMeaning;
  const DriveSettings& settings = drive_->settings();
  const auto long_word = [this](WordMeaning high, std::optional<std::uint16_t> low) {
    return static_cast<std::uint32_t>(word_of_move(high).value_or(0)) << 16 | low.value_or(0);
  };
  const auto steps =
      static_cast<std::int32_t>(long_word(kPositionHigh, word_of_move(kPositionLow)));
  const auto speed = word_of_move(kSpeed) ? word_of_move(kSpeed) : word_of_move(kSpeedLow);
  const auto acceleration = word_of_move(kAcceleration);
  const auto deceleration = word_of_move(kDeceleration);
  MotionBounds bounds;
  bounds.speed_mm_s =
      speed ? long_word(kSpeedHigh, speed) / map_.speed_per_mm_s : settings.max_speed_mm_s;
  bounds.acceleration_mm_s2 =
      acceleration ? acceleration_of(*acceleration) : settings.max_acceleration_mm_s2;
  bounds.deceleration_mm_s2 =
      deceleration ? acceleration_of(*deceleration) : bounds.acceleration_mm_s2;
  return drive_->move_to(steps / map_.steps_per_mm, bounds);
}

}  // namespace raywalk::simulator
