// How a motor drive moves between commands: stretches of constant acceleration.
#pragma once

#include <span>
#include <vector>

namespace raywalk::capture {

// What a motion may use; all positive.
struct MotionBounds {
  double speed_mm_s = 100.0;
  double acceleration_mm_s2 = 200.0;
  double deceleration_mm_s2 = 200.0;
};

struct MotionState {
  double position_mm = 0.0;
  double speed_mm_s = 0.0;  // negative towards lower positions
};

// A motion as a function of the time since it began. Speed changes its sign only where one phase
// ends and the next begins, so the position is monotone within a phase.
class Trajectory {
 public:
  struct Phase {
    double duration_s = 0.0;
    MotionState start{};
    double acceleration_mm_s2 = 0.0;
  };

  // At rest.
  explicit Trajectory(double position_mm) : end_mm_(position_mm) {}
  // The fastest way to rest at the target within the bounds. Where the target is nearer than the
  // way to a halt, or behind, it goes past, halts and comes back; where the speed is too high, it
  // first slows down.
  static Trajectory to(double target_mm, const MotionState& start, const MotionBounds& bounds);
  // Decelerates to rest.
  static Trajectory halt(const MotionState& start, double deceleration_mm_s2);

  std::span<const Phase> phases() const { return phases_; }
  double duration_s() const { return duration_s_; }
  double end_mm() const { return end_mm_; }
  // Before 0 as at 0; from the duration on, at rest at end_mm() exactly.
  MotionState at(double time_s) const;

 private:
  MotionState add_phase(const MotionState& start, double acceleration_mm_s2, double duration_s);

  std::vector<Phase> phases_;
  double duration_s_ = 0.0;
  double end_mm_;
};

}  // namespace raywalk::capture
