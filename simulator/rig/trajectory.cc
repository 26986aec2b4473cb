#include "simulator/rig/trajectory.h"

#include <algorithm>
#include <cmath>

namespace raywalk::capture {
namespace {

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

}  // namespace raywalk::capture
