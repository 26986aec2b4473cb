// The time a capture runs on, so that a test can run a thousand stations in seconds.
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
  // Returns after the duration, or earlier where a signal arrives: whoever waits for long waits in
  // short steps and looks at interrupt_requested() between them.
  virtual void sleep(Duration duration) = 0;
};

// What the wall clock showed, or will show, at a steady time, going by what both show now.
WallTime wall_time_of(const Clock& clock, SteadyTime time);

// The clocks of the machine.
class SystemClock final : public Clock {
 public:
  SteadyTime now() const override;
  WallTime wall_now() const override;
  void sleep(Duration duration) override;
};

}  // namespace raywalk::capture
