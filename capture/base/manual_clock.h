// A clock that stands still until someone sleeps on it: simulated time for tests and fakes.
#pragma once

#include <atomic>

#include "capture/base/clock.h"

namespace raywalk::capture {

// sleep() moves the time of every reader forward at once. The wall clock starts at
// 2026-01-01T00:00:00Z and can be set, also backwards.
class ManualClock final : public Clock {
 public:
  SteadyTime now() const override { return SteadyTime{Duration{passed_ns_.load()}}; }
  WallTime wall_now() const override {
    const Duration since_epoch{wall_start_ns_.load() + passed_ns_.load()};
    return WallTime{std::chrono::duration_cast<WallTime::duration>(since_epoch)};
  }
  void sleep(Duration duration) override {
    if (duration > Duration::zero()) passed_ns_ += duration.count();
  }
  // Moves the wall clock alone, as an operator or a time server does.
  void shift_wall(Duration by) { wall_start_ns_ += by.count(); }

 private:
  std::atomic<std::int64_t> passed_ns_{0};
  std::atomic<std::int64_t> wall_start_ns_{1767225600LL * 1000000000LL};
};

}  // namespace raywalk::capture
