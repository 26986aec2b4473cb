// Configuration of the fake slider of tests, from YAML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace raywalk::capture {

enum class SliderFaultKind {
  kStall,      // the carriage stays in place, the drive still reports a motion
  kIgnore,     // commands other than stop have no effect
  kAlarm,      // stops at once, until reset
  kLowLimit,   // the switch closes
  kHighLimit,  // the switch closes
  kNoContact,  // every call fails, the carriage keeps moving
  kOutlier,    // one reading is off by size_mm
  kDrift,      // the feedback creeps by size_mm per second
  kRunaway,    // stop has no effect
};

// "stall", "low-limit", ...
std::string_view name_of(SliderFaultKind kind);

// A fault that begins once a time is reached or a position passed, whichever is set.
struct FakeSliderFault {
  SliderFaultKind kind = SliderFaultKind::kStall;
  double at_ms = -1.0;    // of the clock, after construction; -1: no time
  double at_mm = -1.0e9;  // when the carriage first passes it; -1e9: no position
  double for_ms = 0.0;    // 0: without end
  double size_mm = 0.0;
};

struct FakeSliderConfig {
  double most_speed_mm_s = 1e6;  // limit of the motor for every command
  double most_acceleration_mm_s2 = 1e6;
  double backlash_mm = 0.0;  // lag of the carriage behind the feedback in downward motion
  double noise_mm = 0.0;     // standard deviation of the feedback
  int seed = 1;
  double start_mm = 0.0;  // initial position of the carriage, from the home switch
  bool homed = true;
  bool reports_flags = true;  // whether the drive reports moving, homed, in position, ...
  int alarm_code = 17;
  std::vector<FakeSliderFault> faults;
};

// Keys are named as the members; faults are a sequence of mappings. Throws UsageError as
// SettingsSchema does, and for a fault with neither time nor position.
FakeSliderConfig parse_fake_slider_config(std::string_view yaml, const std::string& source);

}  // namespace raywalk::capture
