// The motor drive of the simulated rig and the carriage on its rail: motion, switches, backlash and
// faults, without the protocol.
//
// Rail positions count from the home switch, in millimetres. The drive knows only its motor, whose
// count becomes 0 where homing finds the switch; the carriage follows the motor with backlash. What
// the drive reports (DriveState) and what is true (DriveTruth) are kept apart.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "capture/base/clock.h"
#include "capture/simulated/rig/trajectory.h"
#include "capture/simulated/virtual_room/hash_random.h"

namespace raywalk::capture {

struct DriveSettings {
  int seed = 1;  // of the feedback's noise
  // Where the limit switches stop the carriage; the home switch at 0 lies between.
  double low_switch_mm = -20.0;
  double high_switch_mm = 2000.0;
  double power_on_mm = 300.0;  // where the carriage stands at first
  double max_speed_mm_s = 500.0;
  double max_acceleration_mm_s2 = 2000.0;
  double homing_speed_mm_s = 50.0;
  double backlash_mm = 0.02;       // full play between motor and carriage
  double feedback_noise_mm = 0.0;  // standard deviation of one reading
};

enum class DriveFault {
  kStall,     // the motor is blocked, though the drive believes that it moves
  kAlarm,     // amount: the alarm's code; lasts until it is reset
  kLowLimit,  // a limit switch reads as pressed: the motor stops, and refuses that way
  kHighLimit,
  kFeedbackJump,   // amount: millimetres that the feedback is off
  kFeedbackDrift,  // amount: millimetres per second by which the feedback runs away
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

// A range that grows with what is added to it.
struct Extremes {
  double low_mm = 0.0;
  double high_mm = 0.0;
  bool any = false;

  void add(double mm);
};

// What happens on the rail. Extremes start anew when homing ends.
struct DriveTruth {
  double carriage_mm = 0.0;
  std::optional<Duration> still_for{};  // since the motor stopped; none while it moves
  Extremes commanded{};                 // targets of moves, as commanded
  Extremes visited{};                   // where the carriage has been, at any time
  int moves = 0;                        // commanded
};

// Safe to use from several threads. Time is the given clock's alone: what happened between two
// calls is worked out exactly at the second one.
class SimulatedDrive {
 public:
  SimulatedDrive(const DriveSettings& settings, const Clock* clock);

  const DriveSettings& settings() const { return settings_; }

  // An absolute move at no more than the drive's own speed and acceleration; a new one takes over
  // from one under way. Ignored in an alarm. Returns false, and does nothing, where a value is not
  // one that a drive can use: a target that is not finite, a speed or acceleration that is not
  // positive.
  bool move_to(double target_mm, const MotionBounds& bounds);
  void home();
  void stop();
  void reset_alarm();

  DriveState state();
  DriveTruth truth();

  // After so long, and for so long, or where that is zero until clear_faults() (an alarm: until it
  // is reset).
  void inject(DriveFault fault, double amount, Duration lasting, Duration delay = {});
  // Also those that have not come yet.
  void clear_faults();
  // Called with the target of every move before the drive obeys; it may inject faults. Set it
  // before the first command.
  void on_move(std::function<void(double target_mm)> observer) { observer_ = std::move(observer); }

 private:
  struct ActiveFault {
    SteadyTime since{};
    std::optional<SteadyTime> until{};
    double amount = 0.0;
  };
  struct PendingFault {
    DriveFault fault{};
    double amount = 0.0;
    Duration lasting{};
  };
  enum class Homing { kNone, kOffSwitch, kOntoSwitch };

  void advance();
  void advance_to(SteadyTime time);
  void end_motion(SteadyTime time);
  void follow(double motor_mm);
  void begin_fault(const PendingFault& pending);
  void stall(const ActiveFault& fault);
  void begin_due_faults();
  void expire_faults();
  std::optional<SteadyTime> next_event() const;
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
  std::mutex mutex_;
  HashRandom noise_;
  SteadyTime now_{};
  Trajectory motion_;
  SteadyTime motion_began_{};
  bool moving_ = false;
  SteadyTime stopped_at_{};
  std::optional<double> goal_motor_mm_;  // of the move under way
  MotionBounds goal_bounds_{};
  Homing homing_ = Homing::kNone;
  double motor_mm_ = 0.0;     // where the motor stands, in rail positions
  double carriage_mm_ = 0.0;  // within half the backlash of it
  double zero_mm_ = 0.0;      // where the motor's count is 0
  bool homed_ = false;
  int alarm_code_ = 0;
  std::multimap<SteadyTime, PendingFault> pending_;
  std::optional<ActiveFault> stall_, low_limit_, high_limit_, jump_, drift_;
  DriveTruth truth_{};
  std::function<void(double target_mm)> observer_;
};

}  // namespace raywalk::capture
