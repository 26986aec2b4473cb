// The time of views, each run next to one of cv::remap, and whether other programs disturbed it.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "core/base/processor_use.h"
#include "core/base/timing.h"

namespace raywalk {

// Where times come from; tests replace it.
struct TimeSource {
  // Runs the work and returns its times.
  std::function<Times(const std::function<void()>&)> times = [](const std::function<void()>& work) {
    return times_of(work);
  };
  std::function<ProcessorUse()> processor_use = [] { return raywalk::processor_use(); };
};

// One run of a view and, immediately before it, the yardstick: one cv::remap.
struct TimedPair {
  Times remap{};
  Times view{};
};

struct ViewTime {
  double ms = 0.0;     // of a view, median
  double ratio = 0.0;  // of a view to its remap, median
  // The same for the processor time of all threads, which other programs disturb less.
  double cpu_ratio = 0.0;
  double remap_ms = 0.0;  // median
  // The remap does the same work every time: its upper quartile over its least time, minus 1.
  double remap_spread = 0.0;
  double others_share = 0.0;  // of the machine's processor time, used by other processes meanwhile
};

// `pairs`: at least one.
ViewTime view_time_of(std::span<const TimedPair> pairs, double others_share);

// How much a time was disturbed; above 1 it is not to be relied on. `least_remap_ms` is the least
// remap_ms of the settings it is compared with. The limits: a quarter of the remaps takes a quarter
// longer than the fastest, the remap takes a quarter longer than elsewhere in the same trade, other
// processes use a twentieth of the processors.
double disturbance(const ViewTime& time, double least_remap_ms);

// Whether each of `times` is disturbed.
std::vector<bool> disturbed(std::span<const ViewTime> times);

// Measures the disturbed ones again, up to kDisturbedRounds times, and keeps of each the least
// disturbed one. begin_round(n) is called where n of them follow, at least one; measure(i) measures
// the i-th again; kept(i) is called after times[i] was replaced.
inline constexpr int kDisturbedRounds = 2;
void repeat_disturbed(std::vector<ViewTime>* times,
                      const std::function<void(std::ptrdiff_t)>& begin_round,
                      const std::function<ViewTime(std::size_t)>& measure,
                      const std::function<void(std::size_t)>& kept);

}  // namespace raywalk
