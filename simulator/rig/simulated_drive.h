// The simulated motor drive and the carriage on its rail, without the protocol: motion, switches,
// backlash and faults.
//
// Rail positions are in millimetres from the home switch. The drive only knows its motor's count,
// which homing sets to 0 at the switch; the carriage follows the motor with backlash. DriveState is
// what the drive reports, DriveTruth the true state.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "capture/base/clock.h"
#include "simulator/rig/faults.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {

// Limits of a motion; all positive.
struct MotionBounds {
  double speed_mm_s = 100.0;
  double acceleration_mm_s2 = 200.0;
  double deceleration_mm_s2 = 200.0;
};

struct MotionState {
  double position_mm = 0.0;
  double speed_mm_s = 0.0;  // negative towards lower positions
};

// A motion as a function of the time since its start. Speed changes sign only between phases, so
// the position is monotonic within a phase.
class Trajectory {
 public:
  struct Phase {
    double duration_s = 0.0;
    MotionState start{};
    double acceleration_mm_s2 = 0.0;
  };

  // At rest at `position_mm`.
  explicit Trajectory(double position_mm) : end_mm_(position_mm) {}
  // The fastest motion within the bounds that ends at rest at the target. If the target is closer
  // than the braking distance, or behind, it overshoots, stops and returns. If the initial speed
  // exceeds the bound, it first decelerates.
  static Trajectory to(double target_mm, const MotionState& start, const MotionBounds& bounds);
  // Decelerates to rest.
  static Trajectory halt(const MotionState& start, double deceleration_mm_s2);

  std::span<const Phase> phases() const { return phases_; }
  double duration_s() const { return duration_s_; }
  double end_mm() const { return end_mm_; }
  // State at a time, clamped to [0, duration]; at the end exactly at rest at end_mm().
  MotionState at(double time_s) const;

 private:
  MotionState add_phase(const MotionState& start, double acceleration_mm_s2, double duration_s);

  std::vector<Phase> phases_;
  double duration_s_ = 0.0;
  double end_mm_;
};

struct DriveSettings {
  int seed = 1;  // of the feedback noise
  // Positions of the limit switches; the home switch is at 0, between them.
  double low_switch_mm = -20.0;
  double high_switch_mm = 2000.0;
  double power_on_mm = 300.0;  // initial position of the carriage
  double max_speed_mm_s = 500.0;
  double max_acceleration_mm_s2 = 2000.0;
  double homing_speed_mm_s = 50.0;
  double backlash_mm = 0.02;       // full play between motor and carriage
  double feedback_noise_mm = 0.0;  // standard deviation of one reading
};

// What the drive reports.
struct DriveState {
  double feedback_mm = 0.0;
  bool alarm = false;
  int alarm_code = 0;
  bool enabled = true;
  bool homed = false;
  bool moving = false;
  bool in_position = true;
  bool at_low_limit = false;
  bool at_high_limit = false;
};

// The range of the values added to it.
struct Extremes {
  double low_mm = 0.0;
  double high_mm = 0.0;
  bool any = false;

  void add(double mm);
};

// True state of the rail. Extremes are reset when homing ends.
struct DriveTruth {
  double carriage_mm = 0.0;
  std::optional<Duration> still_for{};  // since the motor stopped; empty while it moves
  Extremes commanded{};                 // targets of commanded moves
  Extremes visited{};                   // positions of the carriage
  int moves = 0;                        // commanded moves
};

// Thread-safe. Time is that of the given clock; the motion between two calls is computed exactly at
// the second one.
class SimulatedDrive {
 public:
  // Clock and faults must outlive the drive.
  SimulatedDrive(const DriveSettings& settings, const Clock* clock, Faults* faults);

  const DriveSettings& settings() const { return settings_; }

  // Starts an absolute move, limited to the drive's speed and acceleration; it replaces a move in
  // progress. Ignored during an alarm. Returns false without moving if the target is not finite or
  // a speed or acceleration is not positive.
  bool move_to(double target_mm, const MotionBounds& bounds);
  void home();
  void stop();
  void reset_alarm();

  DriveState state();
  DriveTruth truth();

  // `observer` is called with the target of every move before it starts; it may add faults. Set it
  // before the first command.
  void on_move(std::function<void(double target_mm)> observer) { observer_ = std::move(observer); }

 private:
  enum class Homing { kNone, kOffSwitch, kOntoSwitch };

  void advance();
  void advance_to(SteadyTime time);
  void end_motion(SteadyTime time);
  void follow(double motor_mm);
  void obey_faults();
  void start(const Trajectory& motion);
  void run_to(double motor_mm, const MotionBounds& bounds);
  void resume();
  void block();
  void decelerate();
  bool refuses(double motor_mm) const;
  double motor_at_switch(double carriage_mm, bool from_below) const;
  double feedback_error_mm() const;
  MotionState motor() const;

  const DriveSettings settings_;
  const Clock* clock_;
  Faults* faults_;
  std::mutex mutex_;
  HashRandom noise_;
  SteadyTime now_{};
  Trajectory motion_;
  SteadyTime motion_began_{};
  bool moving_ = false;
  SteadyTime stopped_at_{};
  std::optional<double> goal_motor_mm_;  // of the move in progress
  MotionBounds goal_bounds_{};
  Homing homing_ = Homing::kNone;
  double motor_mm_ = 0.0;     // motor position, as rail position
  double carriage_mm_ = 0.0;  // within half the backlash of the motor
  double zero_mm_ = 0.0;      // rail position where the motor's count is 0
  bool homed_ = false;
  int alarm_code_ = 0;
  bool stalled_ = false;  // by a fault, as the two switches
  bool low_pressed_ = false;
  bool high_pressed_ = false;
  DriveTruth truth_{};
  std::function<void(double target_mm)> observer_;
};

}  // namespace raywalk::simulator
