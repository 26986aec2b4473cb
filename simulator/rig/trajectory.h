// Motion profiles of a motor drive: phases of constant acceleration.
#pragma once

#include <span>
#include <vector>

namespace raywalk::capture {

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

}  // namespace raywalk::capture
