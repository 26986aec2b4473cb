#include "capture/slider/fake_slider.h"

#include <algorithm>
#include <cmath>

#include "capture/base/device_fault.h"

namespace raywalk::capture {

FakeSlider::FakeSlider(const FakeSliderConfig& config, Clock* clock)
    : config_(config),
      clock_(clock),
      made_at_(clock->now()),
      random_(static_cast<std::uint64_t>(config.seed)),
      zero_mm_(config.homed ? 0.0 : config.start_mm),
      homed_(config.homed),
      lowest_mm_(config.start_mm),
      highest_mm_(config.start_mm) {
  for (const FakeSliderFault& fault : config.faults) faults_.push_back({fault});
  motion_.from_mm = config.start_mm;
  motion_.began = made_at_;
}

SliderState FakeSlider::read_state() {
  advance();
  require_contact();
  SliderState state;
  state.position_mm = feedback_mm();
  state.alarm = alarm_;
  state.alarm_code = alarm_ ? config_.alarm_code : 0;
  if (!config_.reports_flags) return state;
  const bool moving = blocked_ || !motion_is_over();
  state.enabled = !alarm_;
  state.homed = homed_;
  state.moving = moving;
  state.in_position = !moving;
  state.at_low_limit = active(SliderFaultKind::kLowLimit) != nullptr;
  state.at_high_limit = active(SliderFaultKind::kHighLimit) != nullptr;
  return state;
}

void FakeSlider::start_homing() {
  advance();
  require_contact();
  homed_ = false;
  begin(0.0, MotionProfile{}, true);
}

void FakeSlider::start_move(SafePosition target, const MotionProfile& profile) {
  advance();
  require_contact();
  ++moves_;
  begin(zero_mm_ + target.mm(), profile, false);
}

// A stop from speed v is the second half of a trapezoid without a cruise: v^2/a long.
void FakeSlider::stop() {
  advance();
  require_contact();
  ++stops_;
  if (active(SliderFaultKind::kRunaway) != nullptr) return;
  const double speed = blocked_ ? 0.0 : speed_mm_s();
  const double from_mm = motor_mm();
  blocked_ = false;
  const double way_mm = speed * speed / profile_.acceleration_mm_s2;
  motion_ = {from_mm,
             motion_.direction,
             clock_->now(),
             Trapezoid(way_mm, profile_),
             1000.0 * speed / profile_.acceleration_mm_s2,
             0.5 * way_mm,
             false};
}

void FakeSlider::reset_alarm() {
  advance();
  require_contact();
  alarm_ = false;
}

double FakeSlider::true_position_mm() {
  advance();
  return motor_mm() - lag_mm_;
}

bool FakeSlider::is_moving() {
  advance();
  return !blocked_ && !motion_is_over();
}

void FakeSlider::begin(double target_mm, const MotionProfile& profile, bool finds_home) {
  if (alarm_ || active(SliderFaultKind::kIgnore) != nullptr) return;
  const double from_mm = motor_mm();
  profile_ = {std::min(profile.speed_mm_s, config_.most_speed_mm_s),
              std::min(profile.acceleration_mm_s2, config_.most_acceleration_mm_s2)};
  motion_ = {from_mm,       target_mm < from_mm ? -1.0 : 1.0,
             clock_->now(), Trapezoid(std::abs(target_mm - from_mm), profile_),
             0.0,           0.0,
             finds_home};
  lag_mm_ = motion_.direction < 0.0 ? -config_.backlash_mm : 0.0;
}

void FakeSlider::advance() {
  advance_faults();
  if (active(SliderFaultKind::kStall) != nullptr && !motion_is_over()) {
    freeze();
    blocked_ = true;
  }
  if (motion_.finds_home && motion_is_over()) {
    motion_.finds_home = false;
    zero_mm_ = motor_mm();
    homed_ = true;
  }
  lowest_mm_ = std::min(lowest_mm_, motor_mm() - lag_mm_);
  highest_mm_ = std::max(highest_mm_, motor_mm() - lag_mm_);
}

void FakeSlider::advance_faults() {
  const double before_mm = motion_.from_mm;
  const double here_mm = motor_mm();
  for (Fault& fault : faults_) {
    if (fault.since) continue;
    const bool on_time =
        fault.what.at_ms >= 0.0 && clock_->now() - made_at_ >= duration_from_ms(fault.what.at_ms);
    const bool passed = fault.what.at_mm >= std::min(before_mm, here_mm) &&
                        fault.what.at_mm <= std::max(before_mm, here_mm);
    if (!on_time && !passed) continue;
    fault.since = clock_->now();
    if (fault.what.kind == SliderFaultKind::kAlarm) {
      alarm_ = true;
      freeze();
    }
  }
}

void FakeSlider::freeze() {
  const double here_mm = motor_mm();
  motion_ = {here_mm, motion_.direction, clock_->now(), Trapezoid(0.0, profile_), 0.0, 0.0, false};
}

double FakeSlider::motor_mm() const {
  const double ms = ms_from_duration(clock_->now() - motion_.began) + motion_.skipped_ms;
  return motion_.from_mm + motion_.direction * (motion_.way.travelled_mm(ms) - motion_.skipped_mm);
}

double FakeSlider::speed_mm_s() const {
  return motion_.way.speed_mm_s(ms_from_duration(clock_->now() - motion_.began) +
                                motion_.skipped_ms);
}

bool FakeSlider::motion_is_over() const {
  return ms_from_duration(clock_->now() - motion_.began) + motion_.skipped_ms >=
         motion_.way.duration_ms();
}

const FakeSlider::Fault* FakeSlider::active(SliderFaultKind kind) const {
  for (const Fault& fault : faults_) {
    if (!fault.since || fault.spent || fault.what.kind != kind) continue;
    const bool lasts = fault.what.for_ms == 0.0 ||
                       clock_->now() - *fault.since <= duration_from_ms(fault.what.for_ms);
    if (lasts) return &fault;
  }
  return nullptr;
}

void FakeSlider::require_contact() const {
  if (active(SliderFaultKind::kNoContact) == nullptr) return;
  throw DeviceFault(FaultKind::kNoContact, "fake slider does not answer; check its cable");
}

double FakeSlider::feedback_mm() {
  double feedback = motor_mm() - zero_mm_;
  if (config_.noise_mm > 0.0) {
    feedback += std::normal_distribution<double>(0.0, config_.noise_mm)(random_);
  }
  for (Fault& fault : faults_) {
    if (!fault.since || fault.spent) continue;
    if (fault.what.kind == SliderFaultKind::kOutlier) {
      feedback += fault.what.size_mm;
      fault.spent = true;
    } else if (fault.what.kind == SliderFaultKind::kDrift) {
      feedback += fault.what.size_mm * ms_from_duration(clock_->now() - *fault.since) / 1000.0;
    }
  }
  return feedback;
}

}  // namespace raywalk::capture
