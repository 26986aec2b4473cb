// One axis of a plot: a range of data laid out on a range of pixels, with ticks at round numbers.
#pragma once

#include <string>
#include <vector>

namespace raywalk {

struct AxisRange {
  double min = 0.0;
  double max = 1.0;
};

class PlotAxis {
 public:
  // Lays [min, max] of the data linearly on pixels from `first_px` (data min) to `last_px` (data
  // max), which may be the smaller one, with about `tick_count` ticks. A range that is empty,
  // reversed or not finite is replaced by one around its minimum (or around 0).
  PlotAxis(AxisRange range, double first_px, double last_px, int tick_count);

  const AxisRange& range() const { return range_; }
  double pixel(double value) const;
  // Multiples of 1, 2 or 5 times a power of ten within the range, in ascending order.
  const std::vector<double>& ticks() const { return ticks_; }
  // The tick as a label, with as many decimals as its spacing needs.
  std::string label(double tick) const;

 private:
  AxisRange range_;
  double first_px_;
  double last_px_;
  std::vector<double> ticks_;
  int decimals_ = 0;
};

// `range` grown to the next ticks outside it, so that data does not touch the frame.
AxisRange rounded_range(AxisRange range, int tick_count);

}  // namespace raywalk
