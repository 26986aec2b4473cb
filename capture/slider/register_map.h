// The layout of a drive's Modbus registers, from YAML, and the words that they hold.
// configs/sliders/*.yaml hold maps; the comments of configs/sliders/generic.yaml explain every key.
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

#include "capture/slider/slider_state.h"

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
  int address = -1;                // -1: the drive has no such command
  std::vector<BlockWord> words{};  // one word is written with function 6, more with function 16

  bool exists() const { return address >= 0; }
};

// A flag of the status word.
struct StatusBit {
  int bit = -1;  // from 0; -1: the drive does not report it
  bool active_low = false;
};

struct RegisterMap {
  std::string name;
  double steps_per_mm = 0.0;     // of commanded and reported positions
  bool low_word_first = false;   // of the feedback position
  bool input_registers = false;  // state is read with function 4 instead of 3
  int position_address = -1;     // two words, signed 32 bits
  int status_address = -1;
  int alarm_address = -1;       // -1: no alarm code; read while the alarm bit is set
  bool one_read = false;        // one request may read all registers from status to position
  double speed_per_mm_s = 0.0;  // register units for 1 mm/s
  // Register units for 1 mm/s^2; or, if the drive takes a time, the speed that it reaches within
  // the milliseconds of the register. The other is 0.
  double acceleration_per_mm_s2 = 0.0;
  double acceleration_time_to_mm_s = 0.0;
  RegisterWrite move{};
  RegisterWrite start{};  // after `move`
  RegisterWrite home{};
  RegisterWrite stop{};
  StatusBit alarm{}, enabled{}, homed{}, moving{}, in_position{}, at_low_limit{}, at_high_limit{};
  // A register with a known value, to check that the map fits the drive.
  int identity_address = -1;  // -1: none
  int identity_value = 0;
};

// Throws UsageError naming file and key, and the line for mistakes that SettingsSchema finds; also
// for a map that cannot move a carriage: no position words, no stop, no scale of the acceleration,
// no alarm bit, a word of a move in another write.
RegisterMap read_register_map(const std::filesystem::path& file);

// Every key that a map's file may have.
std::set<std::string> register_map_keys();

// The nearest whole step. Throws UsageError if it does not fit 32 signed bits.
std::int32_t steps_from_mm(const RegisterMap& map, double mm);

// Of the signed 32-bit steps in two words; `first` has the lower address.
double mm_from_words(const RegisterMap& map, std::uint16_t first, std::uint16_t second);

// The words of a write, in order; `target` and `profile` are those of a move. Throws UsageError,
// naming the value, if the position, the speed or the acceleration does not fit the map's words, or
// if speed or acceleration would be 0. Values are never clamped: a carriage at another speed than
// requested would be a wrong result.
std::vector<std::uint16_t> words_of(const RegisterMap& map, const RegisterWrite& write,
                                    double target_mm = 0.0, const MotionProfile& profile = {});

// A flag of the status word; none if the map does not define it.
std::optional<bool> flag_of(std::uint16_t status, const StatusBit& bit);

}  // namespace raywalk::capture
