#include "core/report/plot_axis.h"

#include <algorithm>
#include <cmath>

#include "core/report/markup.h"

namespace raywalk {
namespace {

// Beyond it doubles have no fractional tick left to label, and spans overflow.
constexpr double kLargestValue = 1e300;

AxisRange usable_range(AxisRange range) {
  const double min =
      std::isfinite(range.min) ? std::clamp(range.min, -kLargestValue, kLargestValue) : 0.0;
  const double max =
      std::isfinite(range.max) ? std::clamp(range.max, -kLargestValue, kLargestValue) : min;
  // A span under a few thousand ulp has no distinct ticks.
  const double least_span = std::max(std::abs(min), std::abs(max)) * 1e-12;
  if (max - min > least_span) return {min, max};
  const double margin = min == 0.0 ? 1.0 : std::abs(min) * 0.5;
  return {min - margin, min + margin};
}

// The largest of 1, 2, 5 times a power of ten that gives at least tick_count intervals.
double tick_spacing(AxisRange range, int tick_count) {
  const double coarsest = (range.max - range.min) / std::max(1, tick_count);
  const double decade = std::pow(10.0, std::floor(std::log10(coarsest)));
  const double mantissa = coarsest / decade;
  return decade * (mantissa >= 5.0 ? 5.0 : mantissa >= 2.0 ? 2.0 : 1.0);
}

}  // namespace

PlotAxis::PlotAxis(AxisRange range, double first_px, double last_px, int tick_count)
    : range_(usable_range(range)), first_px_(first_px), last_px_(last_px) {
  const double spacing = tick_spacing(range_, tick_count);
  decimals_ = std::clamp(static_cast<int>(-std::floor(std::log10(spacing) + 1e-9)), 0, 15);
  // Rounding may push a tick that belongs to an end just outside it.
  const double slack = 1e-9;
  const double first = std::ceil(range_.min / spacing - slack);
  const double last = std::floor(range_.max / spacing + slack);
  const auto count = static_cast<int>(last - first) + 1;
  for (int i = 0; i < count; ++i) ticks_.push_back((first + i) * spacing);
}

double PlotAxis::pixel(double value) const {
  const double share = (value - range_.min) / (range_.max - range_.min);
  return first_px_ + share * (last_px_ - first_px_);
}

std::string PlotAxis::label(double tick) const { return fixed_number(tick, decimals_); }

AxisRange rounded_range(AxisRange range, int tick_count) {
  const AxisRange usable = usable_range(range);
  const double spacing = tick_spacing(usable, tick_count);
  return {std::floor(usable.min / spacing) * spacing, std::ceil(usable.max / spacing) * spacing};
}

}  // namespace raywalk
