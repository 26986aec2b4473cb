// Simulated time for tests and fakes: a clock that advances only by sleep().
#pragma once

#include <atomic>

#include "capture/base/clock.h"

namespace raywalk::capture {

// sleep() advances the clock for all threads at once. The wall clock starts at 2026-01-01T00:00:00Z
// and can be shifted, also backwards.
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
  // Shifts the wall clock alone, as an operator or a time server does.
  void shift_wall(Duration by) { wall_start_ns_ += by.count(); }

 private:
  std::atomic<std::int64_t> passed_ns_{0};
  std::atomic<std::int64_t> wall_start_ns_{1767225600LL * 1000000000LL};
};

}  // namespace raywalk::capture
