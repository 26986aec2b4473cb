// For tests: register maps whose moves take one write or two.
#pragma once

#include "capture/slider/register_map.h"

namespace raywalk::capture {

// As Leadshine's PR0 drives: one block starts a move with its last word; home and stop share a
// register.
inline RegisterMap one_write_map() {
  using enum WordMeaning;
  RegisterMap map;
  map.name = "one-write";
  map.steps_per_mm = 100.0;
  map.position_address = 0x1014;
  map.status_address = 0x1003;
  map.alarm_address = 0x2203;
  map.speed_per_mm_s = 0.6;
  map.acceleration_time_to_mm_s = 1000.0;
  map.move = {0x6200,
              {{kConstant, 1},
               {kPositionHigh, 0},
               {kPositionLow, 0},
               {kSpeed, 0},
               {kAcceleration, 0},
               {kDeceleration, 0},
               {kConstant, 0},
               {kConstant, 0x10}}};
  map.home = {0x6002, {{kConstant, 0x20}}};
  map.stop = {0x6002, {{kConstant, 0x40}}};
  map.reset_alarm = RegisterWrite{0x1801, {{kConstant, 0x1111}}};
  map.alarm = StatusBit{0};
  map.enabled = StatusBit{1};
  map.moving = StatusBit{2};
  map.in_position = StatusBit{4};
  map.homed = StatusBit{6};
  return map;
}

// The other variants: state in input registers, low word first, 32-bit speed, acceleration instead
// of ramp time, a separate start block, an active-low flag, an identity register.
inline RegisterMap two_write_map() {
  using enum WordMeaning;
  RegisterMap map;
  map.name = "two-write";
  map.steps_per_mm = 1000.0;
  map.low_word_first = true;
  map.input_registers = true;
  map.position_address = 2;
  map.status_address = 1;
  map.alarm_address = 4;
  map.speed_per_mm_s = 1000.0;
  map.acceleration_per_mm_s2 = 10.0;
  map.move = {
      100,
      {{kPositionLow, 0}, {kPositionHigh, 0}, {kSpeedLow, 0}, {kSpeedHigh, 0}, {kAcceleration, 0}}};
  map.start = RegisterWrite{110, {{kConstant, 1}}};
  map.home = {111, {{kConstant, 1}}};
  map.stop = {112, {{kConstant, 1}}};
  map.reset_alarm = RegisterWrite{113, {{kConstant, 1}}};
  map.alarm = StatusBit{3, true};
  map.moving = StatusBit{0};
  map.homed = StatusBit{1};
  map.at_low_limit = StatusBit{14};
  map.at_high_limit = StatusBit{15};
  map.identity_address = 0;
  map.identity_value = 0x5257;
  return map;
}

}  // namespace raywalk::capture
