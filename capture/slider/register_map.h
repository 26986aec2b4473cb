// The layout of a drive's Modbus registers, from YAML. configs/sliders/*.yaml hold maps; the
// comments of configs/sliders/generic.yaml explain every key.
//
// The scheme covers drives that move on one write: a block of words written with function 16, in
// which named words hold position, speed and acceleration, and optionally a second write that
// starts the move. Home, stop and reset are writes of fixed words.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace raywalk::capture {

// One word of a block that is written: a number, or a part of a quantity.
enum class WordMeaning {
  kConstant,
  kPositionHigh,  // of a signed 32-bit position in steps
  kPositionLow,
  kSpeed,      // 16 bits
  kSpeedHigh,  // 32 bits
  kSpeedLow,
  kAcceleration,  // 16 bits
  kDeceleration,
};

struct BlockWord {
  WordMeaning meaning = WordMeaning::kConstant;
  std::uint16_t constant = 0;
};

struct RegisterWrite {
  int address = -1;
  std::vector<BlockWord> words;  // one word is written with function 6, more with function 16
};

// A flag of the status word; `bit` from 0.
struct StatusBit {
  int bit = 0;
  bool active_low = false;
};

struct RegisterMap {
  std::string name;
  double steps_per_mm = 100.0;   // of commanded and reported positions
  bool low_word_first = false;   // of the feedback position
  bool input_registers = false;  // state is read with function 4 instead of 3
  int position_address = -1;     // two words, signed 32 bits
  int status_address = -1;
  int alarm_address = -1;       // -1: no alarm code; read while the alarm bit is set
  bool one_read = false;        // one request may read all registers from status to position
  double speed_per_mm_s = 1.0;  // register units for 1 mm/s
  // Register units for 1 mm/s^2; or, if the drive takes a time, the speed that it reaches within
  // the milliseconds of the register. The other is 0.
  double acceleration_per_mm_s2 = 0.0;
  double acceleration_time_to_mm_s = 0.0;
  RegisterWrite move;
  std::optional<RegisterWrite> start;  // after `move`
  RegisterWrite home;
  RegisterWrite stop;
  std::optional<RegisterWrite> reset_alarm;
  std::optional<StatusBit> alarm, enabled, homed, moving, in_position, at_low_limit, at_high_limit;
  // A register with a known value, to check that the map fits the drive.
  int identity_address = -1;  // -1: none
  int identity_value = 0;
};

// Throws UsageError naming file and key, and the line for mistakes that SettingsSchema finds; also
// for a map that cannot move a carriage: no position words, no stop, no scale of the acceleration,
// an alarm code without an alarm bit, a word of a move in another write.
RegisterMap read_register_map(const std::filesystem::path& file);

// Every key that a map's file may have.
std::set<std::string> register_map_keys();

}  // namespace raywalk::capture
