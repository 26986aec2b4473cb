#include "simulator/rig/simulated_drive.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace raywalk::simulator {
namespace {

// Distance that homing backs off if it starts on the switch.
constexpr double kHomingClearance_mm = 5.0;

double seconds_of(Duration duration) { return std::chrono::duration<double>(duration).count(); }

Duration duration_from_s(double seconds) { return duration_from_ms(1e3 * seconds); }

MotionState after(const MotionState& start, double acceleration_mm_s2, double time_s) {
  return {start.position_mm + (start.speed_mm_s + 0.5 * acceleration_mm_s2 * time_s) * time_s,
          start.speed_mm_s + acceleration_mm_s2 * time_s};
}

// Position of rest if the motion decelerates from now on; the braking distance is v^2 / (2 a).
double halting_point(const MotionState& state, double deceleration_mm_s2) {
  return state.position_mm +
         0.5 * state.speed_mm_s * std::abs(state.speed_mm_s) / deceleration_mm_s2;
}

}  // namespace

MotionState Trajectory::add_phase(const MotionState& start, double acceleration_mm_s2,
                                  double duration_s) {
  if (!(duration_s > 0.0)) return start;
  phases_.push_back({duration_s, start, acceleration_mm_s2});
  duration_s_ += duration_s;
  return after(start, acceleration_mm_s2, duration_s);
}

Trajectory Trajectory::halt(const MotionState& start, double deceleration_mm_s2) {
  Trajectory motion(halting_point(start, deceleration_mm_s2));
  motion.add_phase(start, std::copysign(deceleration_mm_s2, -start.speed_mm_s),
                   std::abs(start.speed_mm_s) / deceleration_mm_s2);
  return motion;
}

// Let D be the distance to go and v0 the speed towards the target. Accelerating by a to the peak
// speed p and decelerating by d to rest covers
//   (p^2 - v0^2) / (2 a) + p^2 / (2 d) = D,  so  p^2 = (2 a d D + d v0^2) / (a + d).
// p >= v0 if and only if D >= v0^2 / (2 d), that is, if braking now would not overshoot. A peak
// above the speed limit is cut off, and the rest of D is covered at the limit.
Trajectory Trajectory::to(double target_mm, const MotionState& start, const MotionBounds& bounds) {
  const double a = bounds.acceleration_mm_s2, d = bounds.deceleration_mm_s2;
  const double halt_mm = halting_point(start, d);
  const double sign = target_mm >= halt_mm ? 1.0 : -1.0;
  Trajectory motion(target_mm);
  MotionState state = start;
  if (sign * start.speed_mm_s < 0.0) {
    motion = halt(start, d);
    motion.end_mm_ = target_mm;
    state = {halt_mm, 0.0};
  }
  const double way_mm = sign * (target_mm - state.position_mm), v0 = sign * state.speed_mm_s;
  const double peak_mm_s = std::min(
      bounds.speed_mm_s, std::sqrt(std::max(0.0, (2.0 * a * d * way_mm + d * v0 * v0) / (a + d))));
  const double to_peak = peak_mm_s >= v0 ? a : -d;
  state = motion.add_phase(state, sign * to_peak, (peak_mm_s - v0) / to_peak);
  const double left_mm = sign * (target_mm - state.position_mm) - 0.5 * peak_mm_s * peak_mm_s / d;
  if (peak_mm_s > 0.0) state = motion.add_phase(state, 0.0, left_mm / peak_mm_s);
  motion.add_phase(state, -sign * d, peak_mm_s / d);
  return motion;
}

MotionState Trajectory::at(double time_s) const {
  if (time_s >= duration_s_) return {end_mm_, 0.0};
  double left_s = std::max(0.0, time_s);
  for (const Phase& phase : phases_) {
    if (left_s <= phase.duration_s) return after(phase.start, phase.acceleration_mm_s2, left_s);
    left_s -= phase.duration_s;
  }
  return {end_mm_, 0.0};
}

void Extremes::add(double mm) {
  low_mm = any ? std::min(low_mm, mm) : mm;
  high_mm = any ? std::max(high_mm, mm) : mm;
  any = true;
}

SimulatedDrive::SimulatedDrive(const DriveSettings& settings, const Clock* clock, Faults* faults)
    : settings_(settings),
      clock_(clock),
      faults_(faults),
      noise_(hash_bits(static_cast<std::uint64_t>(settings.seed), 0xd21fe)),
      now_(clock->now()),
      motion_(settings.power_on_mm),
      motion_began_(now_),
      stopped_at_(now_),
      motor_mm_(settings.power_on_mm),
      carriage_mm_(settings.power_on_mm),
      zero_mm_(settings.power_on_mm) {
  truth_.visited.add(carriage_mm_);
}

// Motor position when the carriage reaches a switch: half the backlash ahead of it.
double SimulatedDrive::motor_at_switch(double carriage_mm, bool from_below) const {
  return carriage_mm + (from_below ? 0.5 : -0.5) * settings_.backlash_mm;
}

MotionState SimulatedDrive::motor() const {
  return moving_ ? motion_.at(seconds_of(now_ - motion_began_)) : MotionState{motor_mm_, 0.0};
}

// The motor moved to `motor_mm` without reversing. The carriage stays put until the backlash is
// taken up. At a limit switch the motor stops immediately.
void SimulatedDrive::follow(double motor_mm) {
  const double low = motor_at_switch(settings_.low_switch_mm, false);
  const double high = motor_at_switch(settings_.high_switch_mm, true);
  motor_mm_ = std::clamp(motor_mm, low, high);
  const double half_play = 0.5 * settings_.backlash_mm;
  carriage_mm_ = std::clamp(carriage_mm_, motor_mm_ - half_play, motor_mm_ + half_play);
  truth_.visited.add(carriage_mm_);
  if (motor_mm_ != motor_mm) block();
}

// Stops immediately and discards the target.
void SimulatedDrive::block() {
  motion_ = Trajectory(motor_mm_);
  if (moving_) stopped_at_ = now_;
  moving_ = false;
  goal_motor_mm_.reset();
  homing_ = Homing::kNone;
}

// Decelerates and discards the target.
void SimulatedDrive::decelerate() {
  homing_ = Homing::kNone;
  goal_motor_mm_.reset();
  if (moving_) start(Trajectory::halt(motor(), settings_.max_acceleration_mm_s2));
}

void SimulatedDrive::start(const Trajectory& motion) {
  motion_ = motion;
  motion_began_ = now_;
  moving_ = true;
}

// A triggered limit switch refuses moves towards it.
bool SimulatedDrive::refuses(double motor_mm) const {
  const bool at_low = low_pressed_ || carriage_mm_ <= settings_.low_switch_mm;
  const bool at_high = high_pressed_ || carriage_mm_ >= settings_.high_switch_mm;
  return (at_low && motor_mm < motor_mm_) || (at_high && motor_mm > motor_mm_);
}

void SimulatedDrive::run_to(double motor_mm, const MotionBounds& bounds) {
  if (refuses(motor_mm)) {
    decelerate();
    return;
  }
  goal_motor_mm_ = motor_mm;
  goal_bounds_ = bounds;
  resume();
}

void SimulatedDrive::resume() {
  if (goal_motor_mm_ && !stalled_) start(Trajectory::to(*goal_motor_mm_, motor(), goal_bounds_));
}

void SimulatedDrive::end_motion(SteadyTime time) {
  moving_ = false;
  stopped_at_ = time;
  goal_motor_mm_.reset();
  const MotionBounds slow{settings_.homing_speed_mm_s, settings_.max_acceleration_mm_s2,
                          settings_.max_acceleration_mm_s2};
  if (homing_ == Homing::kOffSwitch) {
    homing_ = Homing::kOntoSwitch;
    run_to(motor_at_switch(0.0, false), slow);
  } else if (homing_ == Homing::kOntoSwitch) {
    homing_ = Homing::kNone;
    zero_mm_ = motor_mm_;
    homed_ = true;
    truth_.visited = {};
    truth_.visited.add(carriage_mm_);
  }
}

// Steps through all events: the end of a phase, where the motor may reverse, the end of a motion,
// where homing may continue, and the start and end of faults.
void SimulatedDrive::advance() {
  const SteadyTime now = clock_->now();
  for (auto change = faults_->next_change(now_); change && *change <= now;
       change = faults_->next_change(now_)) {
    advance_to(*change);
    obey_faults();
  }
  advance_to(now);
  obey_faults();  // also those that were ended before their time
}

void SimulatedDrive::advance_to(SteadyTime time) {
  while (moving_ && now_ < time) {
    const double done_s = seconds_of(now_ - motion_began_);
    double end_s = 0.0;
    for (const Trajectory::Phase& phase : motion_.phases()) {
      end_s += phase.duration_s;
      if (end_s > done_s) break;
    }
    // At least one nanosecond, the clock's resolution, to guarantee progress despite rounding.
    const SteadyTime phase_end =
        std::max(motion_began_ + duration_from_s(end_s), now_ + Duration(1));
    now_ = std::min(phase_end, time);
    const SteadyTime began = motion_began_;
    follow(motor().position_mm);
    const SteadyTime end = began + duration_from_s(motion_.duration_s());
    if (moving_ && now_ >= end) {
      follow(motion_.end_mm());
      if (moving_) end_motion(now_);
    }
  }
  now_ = std::max(now_, time);
}

// Begins and ends what the faults at now_ do to the motor.
void SimulatedDrive::obey_faults() {
  if (const auto code = faults_->occurs(RigFault::kAlarm, now_)) {
    alarm_code_ = std::max(1, static_cast<int>(*code));
    decelerate();
  }
  const auto press = [this](RigFault kind, bool* pressed) {
    const bool was_pressed = std::exchange(*pressed, faults_->lasting(kind, now_).has_value());
    if (*pressed && !was_pressed) block();
  };
  press(RigFault::kLowLimit, &low_pressed_);
  press(RigFault::kHighLimit, &high_pressed_);
  const bool was_stalled =
      std::exchange(stalled_, faults_->lasting(RigFault::kStall, now_).has_value());
  if (stalled_ && !was_stalled) {
    // The command is kept and resumes when the motor is freed.
    const auto goal = goal_motor_mm_;
    const Homing homing = homing_;
    block();
    goal_motor_mm_ = goal;
    homing_ = homing;
  }
  if (was_stalled && !stalled_) resume();
}

double SimulatedDrive::feedback_error_mm() const {
  const auto jump = faults_->lasting(RigFault::kFeedbackJump, now_);
  const auto drift = faults_->lasting(RigFault::kFeedbackDrift, now_);
  double error_mm = jump ? jump->amount : 0.0;
  if (drift) error_mm += drift->amount * seconds_of(now_ - drift->since);
  return error_mm;
}

bool SimulatedDrive::move_to(double target_mm, const MotionBounds& bounds) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  if (!std::isfinite(target_mm) || !positive(bounds.speed_mm_s) ||
      !positive(bounds.acceleration_mm_s2) || !positive(bounds.deceleration_mm_s2)) {
    return false;
  }
  if (observer_) observer_(target_mm);
  const std::lock_guard lock(mutex_);
  advance();
  ++truth_.moves;
  truth_.commanded.add(target_mm);
  if (alarm_code_ != 0) return true;
  homing_ = Homing::kNone;
  run_to(target_mm + zero_mm_,
         {std::min(bounds.speed_mm_s, settings_.max_speed_mm_s),
          std::min(bounds.acceleration_mm_s2, settings_.max_acceleration_mm_s2),
          std::min(bounds.deceleration_mm_s2, settings_.max_acceleration_mm_s2)});
  return true;
}

// The switch is pressed from the low end up to 0, which tells the drive the direction to move. It
// is always approached from above, so that the backlash is on the same side.
void SimulatedDrive::home() {
  const std::lock_guard lock(mutex_);
  advance();
  if (alarm_code_ != 0) return;
  homed_ = false;
  const bool on_switch = carriage_mm_ <= 0.0;
  homing_ = on_switch ? Homing::kOffSwitch : Homing::kOntoSwitch;
  run_to(on_switch ? motor_at_switch(kHomingClearance_mm, true) : motor_at_switch(0.0, false),
         {settings_.homing_speed_mm_s, settings_.max_acceleration_mm_s2,
          settings_.max_acceleration_mm_s2});
}

void SimulatedDrive::stop() {
  const std::lock_guard lock(mutex_);
  advance();
  decelerate();
}

void SimulatedDrive::reset_alarm() {
  const std::lock_guard lock(mutex_);
  advance();
  alarm_code_ = 0;
}

DriveState SimulatedDrive::state() {
  const std::lock_guard lock(mutex_);
  advance();
  DriveState state;
  state.feedback_mm = motor_mm_ - zero_mm_ + feedback_error_mm();
  if (settings_.feedback_noise_mm > 0.0) {
    state.feedback_mm += settings_.feedback_noise_mm * noise_.normal();
  }
  state.alarm = alarm_code_ != 0;
  state.alarm_code = alarm_code_;
  state.enabled = !state.alarm;
  state.homed = homed_;
  state.moving = moving_ || goal_motor_mm_.has_value();
  state.in_position = !state.moving && !state.alarm;
  state.at_low_limit = low_pressed_ || carriage_mm_ <= settings_.low_switch_mm;
  state.at_high_limit = high_pressed_ || carriage_mm_ >= settings_.high_switch_mm;
  return state;
}

DriveTruth SimulatedDrive::truth() {
  const std::lock_guard lock(mutex_);
  advance();
  DriveTruth truth = truth_;
  truth.carriage_mm = carriage_mm_;
  if (!moving_) truth.still_for = now_ - stopped_at_;
  return truth;
}

}  // namespace raywalk::simulator
