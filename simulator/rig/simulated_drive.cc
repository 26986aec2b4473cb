#include "simulator/rig/simulated_drive.h"

#include <algorithm>
#include <cmath>

namespace raywalk::capture {
namespace {

// Distance that homing backs off if it starts on the switch.
constexpr double kHomingClearance_mm = 5.0;

double seconds_of(Duration duration) { return std::chrono::duration<double>(duration).count(); }

Duration duration_from_s(double seconds) { return duration_from_ms(1e3 * seconds); }

}  // namespace

void Extremes::add(double mm) {
  low_mm = any ? std::min(low_mm, mm) : mm;
  high_mm = any ? std::max(high_mm, mm) : mm;
  any = true;
}

SimulatedDrive::SimulatedDrive(const DriveSettings& settings, const Clock* clock)
    : settings_(settings),
      clock_(clock),
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
  const bool at_low = low_limit_ || carriage_mm_ <= settings_.low_switch_mm;
  const bool at_high = high_limit_ || carriage_mm_ >= settings_.high_switch_mm;
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
  if (goal_motor_mm_ && !stall_) start(Trajectory::to(*goal_motor_mm_, motor(), goal_bounds_));
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
  while (const auto event = next_event()) {
    if (*event > now) break;
    advance_to(*event);
    expire_faults();
    begin_due_faults();
  }
  advance_to(now);
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

std::optional<SteadyTime> SimulatedDrive::next_event() const {
  std::optional<SteadyTime> next;
  if (!pending_.empty()) next = pending_.begin()->first;
  for (const auto* fault : {&stall_, &low_limit_, &high_limit_, &jump_, &drift_}) {
    if (*fault && (*fault)->until && (!next || *(*fault)->until < *next)) next = (*fault)->until;
  }
  return next;
}

void SimulatedDrive::expire_faults() {
  const auto is_over = [this](const std::optional<ActiveFault>& fault) {
    return fault && fault->until && *fault->until <= now_;
  };
  for (auto* fault : {&low_limit_, &high_limit_, &jump_, &drift_}) {
    if (is_over(*fault)) fault->reset();
  }
  if (is_over(stall_)) {
    stall_.reset();
    resume();
  }
}

void SimulatedDrive::begin_due_faults() {
  while (!pending_.empty() && pending_.begin()->first <= now_) {
    begin_fault(pending_.begin()->second);
    pending_.erase(pending_.begin());
  }
}

double SimulatedDrive::feedback_error_mm() const {
  double error_mm = jump_ ? jump_->amount : 0.0;
  if (drift_) error_mm += drift_->amount * seconds_of(now_ - drift_->since);
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
  state.at_low_limit = low_limit_ || carriage_mm_ <= settings_.low_switch_mm;
  state.at_high_limit = high_limit_ || carriage_mm_ >= settings_.high_switch_mm;
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

void SimulatedDrive::inject(DriveFault fault, double amount, Duration lasting, Duration delay) {
  const std::lock_guard lock(mutex_);
  advance();
  pending_.emplace(now_ + delay, PendingFault{fault, amount, lasting});
  begin_due_faults();
}

void SimulatedDrive::begin_fault(const PendingFault& pending) {
  ActiveFault active{now_, std::nullopt, pending.amount};
  if (pending.lasting > Duration::zero()) active.until = now_ + pending.lasting;
  switch (pending.fault) {
    case DriveFault::kStall:
      stall(active);
      break;
    case DriveFault::kAlarm:
      alarm_code_ = std::max(1, static_cast<int>(pending.amount));
      decelerate();
      break;
    case DriveFault::kLowLimit:
      block();
      low_limit_ = active;
      break;
    case DriveFault::kHighLimit:
      block();
      high_limit_ = active;
      break;
    case DriveFault::kFeedbackJump:
      jump_ = active;
      break;
    case DriveFault::kFeedbackDrift:
      drift_ = active;
      break;
  }
}

// Unlike block(), keeps the command, which resumes when the motor is freed.
void SimulatedDrive::stall(const ActiveFault& fault) {
  const auto goal = goal_motor_mm_;
  const Homing homing = homing_;
  block();
  goal_motor_mm_ = goal;
  homing_ = homing;
  stall_ = fault;
}

void SimulatedDrive::clear_faults() {
  const std::lock_guard lock(mutex_);
  advance();
  pending_.clear();
  low_limit_.reset();
  high_limit_.reset();
  jump_.reset();
  drift_.reset();
  alarm_code_ = 0;
  if (stall_) {
    stall_.reset();
    resume();
  }
}

}  // namespace raywalk::capture
