// A register map as written in its YAML file, before the words of writes are parsed.
#pragma once

#include <string>
#include <vector>

#include "core/files/settings.h"

namespace raywalk::capture {

// Register addresses are 16-bit words of the protocol.
inline constexpr int kLastAddress = 0xffff;

// An address or bit of -1: the drive has none.
struct WriteText {
  int address = -1;
  std::vector<std::string> words;  // numbers, or names such as "position_high"
};

struct StatusBitText {
  int bit = -1;
  bool active_low = false;
};

struct RegisterMapText {
  std::string name;
  double steps_per_mm = 0.0;
  bool low_word_first = false;
  bool input_registers = false;
  bool one_read = false;
  int position_address = -1;
  int status_address = -1;
  int alarm_address = -1;
  double speed_per_mm_s = 0.0;
  double acceleration_per_mm_s2 = 0.0;
  double acceleration_time_to_mm_s = 0.0;
  WriteText move, start, home, stop, reset_alarm;
  StatusBitText alarm, enabled, homed, moving, in_position, at_low_limit, at_high_limit;
  int identity_address = -1;
  int identity_value = 0;
};

// Binds every key of a register map; `text` must outlive the schema's use.
SettingsSchema register_map_schema(RegisterMapText* text);

}  // namespace raywalk::capture
