// One axis of a plot: a range of data laid out on a range of pixels, with ticks at round numbers.
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
  // Lays [min, max] of the data on pixels from `first_px` (data min) to `last_px` (data max), which
  // may be the smaller one, with about `tick_count` ticks. A range that is empty, reversed or not
  // finite, or on a logarithmic axis not positive, is replaced by one around its minimum (or around
  // 0, where the axis has it, or 1).
  PlotAxis(AxisRange range, double first_px, double last_px, int tick_count,
           AxisScale scale = AxisScale::kLinear);

  const AxisRange& range() const { return range_; }
  // On a logarithmic axis values must be positive.
  double pixel(double value) const;
  // Multiples of 1, 2 or 5 times a power of ten within the range, in ascending order; on a
  // logarithmic axis 1, 2 and 5 times every power of ten, or where those are too many powers alone.
  const std::vector<double>& ticks() const { return ticks_; }
  // The tick as a label, with as many decimals as its spacing needs, or on a logarithmic axis as it
  // needs itself; "1e-6" where the ticks are powers alone.
  std::string label(double tick) const;

 private:
  void find_logarithmic_ticks(int tick_count);

  AxisScale scale_;
  AxisRange range_;
  double first_px_;
  double last_px_;
  std::vector<double> ticks_;
  bool powers_ = false;  // of ten are the ticks, and nothing between
  int decimals_ = 0;
};

// `range` grown to the next ticks outside it, so that data does not touch the frame.
AxisRange rounded_range(AxisRange range, int tick_count, AxisScale scale = AxisScale::kLinear);

}  // namespace raywalk
