// A slider that exists only in tests, as YAML describes it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace raywalk::capture {

// Something that goes wrong once a time is reached or a position passed, whichever is set.
struct FakeSliderFault {
  // stall: the carriage stays where it is, the drive goes on reporting a motion. ignore: commands
  // but stop have no effect. alarm: stops at once, until reset. low-limit, high-limit: the switch
  // closes. no-contact: every call fails, the carriage goes on. outlier: one reading is off by
  // size_mm. drift: the feedback creeps by size_mm per second. runaway: stop has no effect.
  std::string kind = "stall";
  double at_ms = -1.0;    // of the clock, after construction; -1: no time
  double at_mm = -1.0e9;  // when the carriage first passes it; -1e9: no position
  double for_ms = 0.0;    // 0: for ever
  double size_mm = 0.0;
};

struct FakeSliderConfig {
  double most_speed_mm_s = 1e6;  // of the motor, whatever a command says
  double most_acceleration_mm_s2 = 1e6;
  double backlash_mm = 0.0;  // the carriage lags behind the feedback by this on its way down
  double noise_mm = 0.0;     // standard deviation of the feedback
  int seed = 1;
  double start_mm = 0.0;  // where the carriage stands at first, from the home switch
  bool homed = true;
  bool reports_flags = true;  // whether the drive tells moving, homed, in position and so on
  int alarm_code = 17;
  std::vector<FakeSliderFault> faults;
};

// Keys are named as the members; faults are a sequence of mappings. Throws UsageError as
// SettingsSchema does, and for a fault with neither time nor position.
FakeSliderConfig parse_fake_slider_config(std::string_view yaml, const std::string& source);

}  // namespace raywalk::capture
