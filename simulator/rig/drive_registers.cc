#include "simulator/rig/drive_registers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "simulator/rig/modbus_frames.h"

namespace raywalk::capture {
namespace {

constexpr std::uint8_t kReadHolding = 3, kReadInput = 4, kWriteOne = 6, kWriteSeveral = 16;
constexpr std::uint8_t kIllegalFunction = 1, kIllegalAddress = 2, kIllegalValue = 3;

ModbusBytes exception_reply(int function, std::uint8_t code) {
  return {static_cast<std::uint8_t>(function | 0x80), code};
}

void append_word(std::uint16_t word, ModbusBytes* bytes) {
  bytes->push_back(static_cast<std::uint8_t>(word >> 8));
  bytes->push_back(static_cast<std::uint8_t>(word & 0xff));
}

// Saturates to the signed 32 bits of the feedback registers.
std::uint32_t steps_from_mm(double mm, double steps_per_mm) {
  constexpr double kMin = std::numeric_limits<std::int32_t>::min();
  constexpr double kMax = std::numeric_limits<std::int32_t>::max();
  const double steps = std::clamp(std::round(mm * steps_per_mm), kMin, kMax);
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(steps));
}

}  // namespace

DriveRegisters::DriveRegisters(const RegisterMap& map, SimulatedDrive* drive)
    : map_(map), drive_(drive) {}

ModbusBytes DriveRegisters::answer(std::span<const std::uint8_t> pdu) {
  const int function = pdu.empty() ? 0 : pdu[0];
  const bool reads = function == kReadHolding || function == kReadInput;
  if (!reads && function != kWriteOne && function != kWriteSeveral) {
    return exception_reply(function, kIllegalFunction);
  }
  if (pdu.size() < 5) return exception_reply(function, kIllegalValue);
  const int address = word_at(pdu, 1), count = word_at(pdu, 3);
  if (reads) {
    if (pdu.size() != 5 || count < 1 || count > 125) {
      return exception_reply(function, kIllegalValue);
    }
    return read(function, address, count);
  }
  std::vector<std::uint16_t> words;
  if (function == kWriteOne) {
    if (pdu.size() != 5) return exception_reply(function, kIllegalValue);
    words.push_back(word_at(pdu, 3));
  } else {
    const auto bytes = 2 * static_cast<std::size_t>(count);
    if (count < 1 || count > 123 || pdu.size() != 6 + bytes || pdu[5] != bytes) {
      return exception_reply(function, kIllegalValue);
    }
    for (std::size_t i = 0; i < bytes; i += 2) words.push_back(word_at(pdu, 6 + i));
  }
  ModbusBytes reply = write(function, address, words);
  // The reply to both functions is the beginning of the request.
  if (reply.empty()) reply.assign(pdu.begin(), pdu.begin() + 5);
  return reply;
}

// Registers in gaps of the map read as 0. Reading beyond its ends is an error.
ModbusBytes DriveRegisters::read(int function, int address, int count) {
  const bool holds_state = (function == kReadInput) == map_.input_registers;
  std::map<int, std::uint16_t> words;
  if (holds_state) words = state_words();
  const int last_address = address + count - 1;
  const bool in_state =
      !words.empty() && address >= words.begin()->first && last_address <= words.rbegin()->first;
  bool in_blocks = function == kReadHolding;
  for (int at = address; at <= last_address; ++at) in_blocks = in_blocks && is_writable(at);
  if (!in_state && !in_blocks) return exception_reply(function, kIllegalAddress);
  ModbusBytes reply{static_cast<std::uint8_t>(function), static_cast<std::uint8_t>(2 * count)};
  for (int at = address; at <= last_address; ++at) {
    std::uint16_t word = 0;
    if (const auto kept = written_.find(at); kept != written_.end()) word = kept->second;
    if (const auto state = words.find(at); state != words.end()) word = state->second;
    append_word(word, &reply);
  }
  return reply;
}

std::map<int, std::uint16_t> DriveRegisters::state_words() {
  const DriveState state = drive_->state();
  const std::uint32_t steps = steps_from_mm(state.feedback_mm, map_.steps_per_mm);
  const auto high = static_cast<std::uint16_t>(steps >> 16);
  const auto low = static_cast<std::uint16_t>(steps & 0xffff);
  std::map<int, std::uint16_t> words;
  words[map_.position_address] = map_.low_word_first ? low : high;
  words[map_.position_address + 1] = map_.low_word_first ? high : low;
  words[map_.status_address] = status_word(state);
  if (map_.alarm_address >= 0) {
    words[map_.alarm_address] = static_cast<std::uint16_t>(state.alarm_code);
  }
  if (map_.identity_address >= 0) {
    words[map_.identity_address] = static_cast<std::uint16_t>(map_.identity_value);
  }
  return words;
}

std::uint16_t DriveRegisters::status_word(const DriveState& state) const {
  unsigned word = 0;
  const auto set = [&word](const std::optional<StatusBit>& bit, bool value) {
    if (bit && value != bit->active_low) word |= 1U << bit->bit;
  };
  set(map_.alarm, state.alarm);
  set(map_.enabled, state.enabled);
  set(map_.homed, state.homed);
  set(map_.moving, state.moving);
  set(map_.in_position, state.in_position);
  set(map_.at_low_limit, state.at_low_limit);
  set(map_.at_high_limit, state.at_high_limit);
  return static_cast<std::uint16_t>(word);
}

bool DriveRegisters::is_writable(int address) const {
  const auto holds = [address](const RegisterWrite& block) {
    return address >= block.address &&
           address < block.address + static_cast<int>(block.words.size());
  };
  return holds(map_.move) || holds(map_.home) || holds(map_.stop) ||
         (map_.start && holds(*map_.start)) || (map_.reset_alarm && holds(*map_.reset_alarm));
}

// Whether a write of `count` words covered the block and its constants match the map.
bool DriveRegisters::was_written(const RegisterWrite& block, int address, std::size_t count) const {
  const int end = address + static_cast<int>(count);
  const auto size = static_cast<int>(block.words.size());
  if (size == 0 || address > block.address || end < block.address + size) return false;
  for (int i = 0; i < size; ++i) {
    const BlockWord& word = block.words[static_cast<std::size_t>(i)];
    if (word.meaning == WordMeaning::kConstant && written_.at(block.address + i) != word.constant) {
      return false;
    }
  }
  return true;
}

// Returns an exception, or nothing on success.
ModbusBytes DriveRegisters::write(int function, int address, std::span<const std::uint16_t> words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!is_writable(address + static_cast<int>(i))) {
      return exception_reply(function, kIllegalAddress);
    }
  }
  for (std::size_t i = 0; i < words.size(); ++i) {
    written_[address + static_cast<int>(i)] = words[i];
  }
  const auto written = [&](const std::optional<RegisterWrite>& block) {
    return block && was_written(*block, address, words.size());
  };
  if (written(map_.stop)) {
    drive_->stop();
  } else if (written(map_.reset_alarm)) {
    drive_->reset_alarm();
  } else if (written(map_.home)) {
    drive_->home();
  } else if (map_.start ? written(map_.start) : written(map_.move)) {
    if (!start_move(command_of(map_.move))) return exception_reply(function, kIllegalValue);
  }
  return {};
}

DriveRegisters::Command DriveRegisters::command_of(const RegisterWrite& block) const {
  Command command;
  std::uint32_t position = 0;
  bool has_high = false;
  for (std::size_t i = 0; i < block.words.size(); ++i) {
    const auto kept = written_.find(block.address + static_cast<int>(i));
    const std::uint16_t word = kept == written_.end() ? std::uint16_t{0} : kept->second;
    switch (block.words[i].meaning) {
      case WordMeaning::kConstant:
        break;
      case WordMeaning::kPositionHigh:
        position |= static_cast<std::uint32_t>(word) << 16;
        has_high = true;
        break;
      case WordMeaning::kPositionLow:
        position |= word;
        break;
      case WordMeaning::kSpeed:
      case WordMeaning::kSpeedLow:
        command.speed |= word;
        command.has_speed = true;
        break;
      case WordMeaning::kSpeedHigh:
        command.speed |= static_cast<std::int64_t>(word) << 16;
        break;
      case WordMeaning::kAcceleration:
        command.acceleration = word;
        command.has_acceleration = true;
        break;
      case WordMeaning::kDeceleration:
        command.deceleration = word;
        command.has_deceleration = true;
        break;
    }
  }
  command.position_steps = has_high
                               ? static_cast<std::int32_t>(position)
                               : static_cast<std::int16_t>(static_cast<std::uint16_t>(position));
  return command;
}

double DriveRegisters::acceleration_of(std::int64_t units) const {
  const auto value = static_cast<double>(units);
  if (map_.acceleration_time_to_mm_s > 0.0) {
    // Milliseconds to reach that speed.
    return map_.acceleration_time_to_mm_s / (1e-3 * value);
  }
  return value / map_.acceleration_per_mm_s2;
}

// Values that the block does not hold default to the drive's maximum.
bool DriveRegisters::start_move(const Command& command) {
  MotionBounds bounds{drive_->settings().max_speed_mm_s, drive_->settings().max_acceleration_mm_s2,
                      drive_->settings().max_acceleration_mm_s2};
  if (command.has_speed)
    bounds.speed_mm_s = static_cast<double>(command.speed) / map_.speed_per_mm_s;
  if (command.has_acceleration) {
    bounds.acceleration_mm_s2 = bounds.deceleration_mm_s2 = acceleration_of(command.acceleration);
  }
  if (command.has_deceleration) bounds.deceleration_mm_s2 = acceleration_of(command.deceleration);
  return drive_->move_to(static_cast<double>(command.position_steps) / map_.steps_per_mm, bounds);
}

}  // namespace raywalk::capture
