#include "core/report/plot_axis.h"

#include <algorithm>
#include <cmath>

#include "core/report/markup.h"

namespace raywalk {
namespace {

// Larger values would overflow the span.
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

// The same for a logarithmic axis: positive.
AxisRange positive_range(AxisRange range) {
  const auto usable = [](double value) { return std::isfinite(value) && value > 0.0; };
  const double min = usable(range.min) ? std::max(range.min, 1.0 / kLargestValue) : 1.0;
  const double max = usable(range.max) ? std::min(range.max, kLargestValue) : min;
  if (max > min * (1.0 + 1e-9)) return {min, max};
  return {min / std::sqrt(10.0), min * std::sqrt(10.0)};
}

AxisRange usable_on(AxisScale scale, AxisRange range) {
  return scale == AxisScale::kLinear ? usable_range(range) : positive_range(range);
}

// Rounding may push the tick at an end just outside the range.
constexpr double kTickSlack = 1e-9;

std::vector<double> linear_ticks(AxisRange range, int tick_count) {
  const double spacing = tick_spacing(range, tick_count);
  const double first = std::ceil(range.min / spacing - kTickSlack);
  const double last = std::floor(range.max / spacing + kTickSlack);
  const auto count = static_cast<int>(last - first) + 1;
  std::vector<double> ticks;
  ticks.reserve(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) ticks.push_back((first + i) * spacing);
  return ticks;
}

// 1, 2 and 5 times every power of ten in the range.
std::vector<double> rounded_logarithmic_ticks(AxisRange range) {
  const int first = static_cast<int>(std::floor(std::log10(range.min)));
  const int last = static_cast<int>(std::floor(std::log10(range.max) + kTickSlack));
  std::vector<double> ticks;
  for (int decade = first; decade <= last; ++decade) {
    for (const double step : {1.0, 2.0, 5.0}) {
      const double tick = step * std::pow(10.0, decade);
      const bool inside =
          tick >= range.min * (1.0 - kTickSlack) && tick <= range.max * (1.0 + kTickSlack);
      if (inside) ticks.push_back(tick);
    }
  }
  return ticks;
}

// Powers of ten in the range, thinned if there are many.
std::vector<double> decades(AxisRange range, int tick_count) {
  const int first = static_cast<int>(std::ceil(std::log10(range.min) - kTickSlack));
  const int last = static_cast<int>(std::floor(std::log10(range.max) + kTickSlack));
  const int step = (last - first) / std::max(1, tick_count) + 1;
  std::vector<double> ticks;
  for (int decade = first; decade <= last; decade += step) {
    ticks.push_back(std::pow(10.0, decade));
  }
  return ticks;
}

int decimals_of(double spacing) {
  return std::clamp(static_cast<int>(-std::floor(std::log10(spacing) + kTickSlack)), 0, 15);
}

}  // namespace

PlotAxis::PlotAxis(AxisRange range, double first_px, double last_px, int tick_count,
                   AxisScale scale)
    : scale_(scale),
      range_(usable_on(scale, range)),
      first_px_(first_px),
      last_px_(last_px),
      decimals_(decimals_of(tick_spacing(range_, tick_count))) {
  if (scale == AxisScale::kLinear) {
    ticks_ = linear_ticks(range_, tick_count);
  } else {
    find_logarithmic_ticks(tick_count);
  }
}

void PlotAxis::find_logarithmic_ticks(int tick_count) {
  ticks_ = rounded_logarithmic_ticks(range_);
  if (ticks_.size() < 2) {
    ticks_ = linear_ticks(range_, tick_count);
  } else if (2 * std::ssize(ticks_) > 3 * tick_count) {
    ticks_ = decades(range_, tick_count);
    powers_ = true;
  }
}

double PlotAxis::pixel(double value) const {
  const double share = scale_ == AxisScale::kLinear
                           ? (value - range_.min) / (range_.max - range_.min)
                           : std::log(value / range_.min) / std::log(range_.max / range_.min);
  return first_px_ + share * (last_px_ - first_px_);
}

std::string PlotAxis::label(double tick) const {
  if (scale_ == AxisScale::kLinear) return fixed_number(tick, decimals_);
  if (!powers_) return plain_number(tick, std::max(decimals_, decimals_of(tick)));
  const auto decade = static_cast<int>(std::lround(std::log10(tick)));
  return decade == 0 ? "1" : "1e" + std::to_string(decade);
}

AxisRange rounded_range(AxisRange range, int tick_count, AxisScale scale) {
  const AxisRange usable = usable_on(scale, range);
  if (scale == AxisScale::kLogarithmic) {
    return {std::pow(10.0, std::floor(std::log10(usable.min) + kTickSlack)),
            std::pow(10.0, std::ceil(std::log10(usable.max) - kTickSlack))};
  }
  const double spacing = tick_spacing(usable, tick_count);
  return {std::floor(usable.min / spacing) * spacing, std::ceil(usable.max / spacing) * spacing};
}

}  // namespace raywalk
