// The time of views, each run next to one of cv::remap.
#pragma once

#include <functional>
#include <span>

#include "core/base/timing.h"

namespace raywalk {

// Runs the work and returns the seconds it took; tests replace it.
using TimeSource = std::function<double(const std::function<void()>&)>;
inline double wall_time_s(const std::function<void()>& work) { return times_of(work).wall_s; }

// One run of a view and, immediately before it, the yardstick: one cv::remap.
struct TimedPair {
  double remap_s = 0.0;
  double view_s = 0.0;
};

struct ViewTime {
  double ms = 0.0;        // of a view, median
  double ratio = 0.0;     // of a view to its remap, median
  double remap_ms = 0.0;  // median
  // The remap does the same work every time: its upper quartile over its least time, minus 1. Above
  // kBusySpread other programs were busy, and times are less certain.
  double remap_spread = 0.0;
};
inline constexpr double kBusySpread = 0.25;

// `pairs`: at least one.
ViewTime view_time_of(std::span<const TimedPair> pairs);

}  // namespace raywalk
