#include "capture/slider/trapezoid.h"

#include <algorithm>
#include <cmath>

#include "capture/base/units.h"

namespace raywalk::capture {
namespace {

double seconds(double ms) { return ms / kMsPerSecond; }

}  // namespace

// A ramp to speed v takes the time v/a and the distance v^2/(2a). Both ramps fit in the distance d
// if v^2/a <= d; otherwise the top speed is sqrt(a d) and there is no cruise.
Trapezoid::Trapezoid(double distance_mm, const MotionProfile& profile)
    : distance_mm_(distance_mm),
      acceleration_mm_s2_(profile.acceleration_mm_s2),
      peak_mm_s_(std::min(profile.speed_mm_s, std::sqrt(profile.acceleration_mm_s2 * distance_mm))),
      ramp_ms_(kMsPerSecond * peak_mm_s_ / acceleration_mm_s2_),
      cruise_ms_(0.0) {
  if (peak_mm_s_ <= 0.0) return;
  const double ramps_mm = peak_mm_s_ * peak_mm_s_ / acceleration_mm_s2_;
  cruise_ms_ = kMsPerSecond * std::max(0.0, distance_mm_ - ramps_mm) / peak_mm_s_;
}

double Trapezoid::travelled_mm(double ms) const {
  if (ms <= 0.0) return 0.0;
  if (ms >= duration_ms()) return distance_mm_;
  if (ms < ramp_ms_) return 0.5 * acceleration_mm_s2_ * seconds(ms) * seconds(ms);
  const double left_ms = duration_ms() - ms;
  if (left_ms < ramp_ms_) {
    return distance_mm_ - 0.5 * acceleration_mm_s2_ * seconds(left_ms) * seconds(left_ms);
  }
  return peak_mm_s_ * (0.5 * seconds(ramp_ms_) + seconds(ms - ramp_ms_));
}

double Trapezoid::speed_mm_s(double ms) const {
  if (ms <= 0.0 || ms >= duration_ms()) return 0.0;
  return std::min({peak_mm_s_, acceleration_mm_s2_ * seconds(ms),
                   acceleration_mm_s2_ * seconds(duration_ms() - ms)});
}

double stopping_ms(const MotionProfile& profile) {
  return kMsPerSecond * profile.speed_mm_s / profile.acceleration_mm_s2;
}

}  // namespace raywalk::capture
