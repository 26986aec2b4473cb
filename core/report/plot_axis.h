// An axis of a plot: maps a range of data to a range of pixels, with ticks at round numbers.
#pragma once

#include <string>
#include <vector>

namespace raywalk {

struct AxisRange {
  double min = 0.0;
  double max = 1.0;
};

enum class AxisScale { kLinear, kLogarithmic };

class PlotAxis {
 public:
  // Maps [min, max] of the data to pixels from `first_px` (data min) to `last_px` (data max), in
  // either direction, with about `tick_count` ticks. A range that is empty, reversed or not finite,
  // or not positive on a logarithmic axis, is replaced by one around its minimum, or else around 0
  // (linear) or 1 (logarithmic).
  PlotAxis(AxisRange range, double first_px, double last_px, int tick_count,
           AxisScale scale = AxisScale::kLinear);

  const AxisRange& range() const { return range_; }
  // On a logarithmic axis values must be positive.
  double pixel(double value) const;
  // Multiples of 1, 2 or 5 times a power of ten within the range, in ascending order; on a
  // logarithmic axis 1, 2 and 5 times every power of ten, or powers of ten only if those are too
  // many.
  const std::vector<double>& ticks() const { return ticks_; }
  // The label of a tick, with as many decimals as the tick spacing needs (logarithmic: as the tick
  // itself needs); "1e-6" if the ticks are powers of ten only.
  std::string label(double tick) const;

 private:
  void find_logarithmic_ticks(int tick_count);

  AxisScale scale_;
  AxisRange range_;
  double first_px_;
  double last_px_;
  std::vector<double> ticks_;
  bool powers_ = false;  // the ticks are powers of ten only
  int decimals_ = 0;
};

// `range` extended to the next ticks outside it, so that data does not touch the frame.
AxisRange rounded_range(AxisRange range, int tick_count, AxisScale scale = AxisScale::kLinear);

}  // namespace raywalk
