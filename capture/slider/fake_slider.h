// A slider without hardware, for tests of code that uses the Slider interface. It moves by a clock,
// usually a ManualClock, and fails as configured. simulator/room/rig simulates a whole drive
// with its protocol.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "capture/base/clock.h"
#include "capture/slider/fake_slider_config.h"
#include "capture/slider/slider.h"
#include "capture/slider/trapezoid.h"

namespace raywalk::capture {

// Not thread-safe. A command during a motion starts from rest at the current position.
class FakeSlider final : public Slider {
 public:
  FakeSlider(const FakeSliderConfig& config, Clock* clock);

  std::string description() const override { return "fake slider"; }
  // Like all commands, throws kNoContact during such a fault.
  SliderState read_state() override;
  void start_homing() override;
  void start_move(SafePosition target, const MotionProfile& profile) override;
  void stop() override;
  void reset_alarm() override;

  // The truth, which only tests see.
  double true_position_mm();
  bool is_moving();
  int moves_commanded() const { return moves_; }
  int stops_commanded() const { return stops_; }
  double lowest_mm() const { return lowest_mm_; }    // of true positions at any reading
  double highest_mm() const { return highest_mm_; }  // or command

 private:
  struct Motion {
    double from_mm = 0.0;
    double direction = 1.0;
    SteadyTime began{};
    Trapezoid way{0.0, MotionProfile{}};
    double skipped_ms = 0.0;  // of the way's beginning: a stop is the second half of one
    double skipped_mm = 0.0;
    bool finds_home = false;
  };
  struct Fault {
    FakeSliderFault what;
    std::optional<SteadyTime> since{};
    bool spent = false;
  };

  void advance();
  void advance_faults();
  void freeze();
  void begin(double target_mm, const MotionProfile& profile, bool finds_home);
  double motor_mm() const;
  double speed_mm_s() const;
  bool motion_is_over() const;
  const Fault* active(SliderFaultKind kind) const;
  void require_contact() const;
  double feedback_mm();

  FakeSliderConfig config_;
  Clock* clock_;
  SteadyTime made_at_;
  std::vector<Fault> faults_;
  Motion motion_{};
  MotionProfile profile_{};
  std::mt19937_64 random_;
  double zero_mm_ = 0.0;  // of the feedback, from the home switch
  double lag_mm_ = 0.0;   // of the carriage behind the motor
  bool homed_;
  bool alarm_ = false;
  bool blocked_ = false;
  int moves_ = 0;
  int stops_ = 0;
  double lowest_mm_;
  double highest_mm_;
};

}  // namespace raywalk::capture
