// The clock of a capture. Tests replace it by a manual one and run a thousand stations in seconds.
#pragma once

#include <chrono>

namespace raywalk::capture {

using SteadyTime = std::chrono::steady_clock::time_point;  // CLOCK_MONOTONIC, as V4L2 stamps frames
using WallTime = std::chrono::system_clock::time_point;    // UTC
using Duration = std::chrono::nanoseconds;

constexpr Duration duration_from_ms(double ms) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(ms));
}
constexpr double ms_from_duration(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

// Safe to use from several threads at once.
class Clock {
 public:
  virtual ~Clock() = default;

  virtual SteadyTime now() const = 0;
  virtual WallTime wall_now() const = 0;
  // Returns after the duration, or earlier if a signal arrives. Long waits are made of short ones,
  // with a check of interrupt_requested() after each.
  virtual void sleep(Duration duration) = 0;
};

// The wall-clock time at a steady time, from the present difference of the two clocks.
WallTime wall_time_of(const Clock& clock, SteadyTime time);

// The clocks of the machine.
class SystemClock final : public Clock {
 public:
  SteadyTime now() const override;
  WallTime wall_now() const override;
  void sleep(Duration duration) override;
};

}  // namespace raywalk::capture
