// Line plots as SVG: several series over two axes, each linear or logarithmic, with ticks, a legend
// and reference lines.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/report/plot_axis.h"

namespace raywalk {

struct PlotPoint {
  double x = 0.0;
  double y = 0.0;
};

// kRings: points that are drawn hollow, for what matters less.
enum class PlotStyle { kLine, kPoints, kLineAndPoints, kRings };

// What a point leads to and says.
struct PlotMark {
  std::string link{};   // where a click on it goes; empty: nowhere
  std::string title{};  // shown where the reader points at it
  std::string label{};  // printed beside it, where there is room
};

struct PlotSeries {
  std::string name{};  // in the legend; empty: not there
  // A point that is not finite, or has no place on a logarithmic axis, leaves a gap.
  std::vector<PlotPoint> points{};
  PlotStyle style = PlotStyle::kLine;
  std::vector<PlotMark> marks{};  // of each point; empty: none
  // Its colour's place in the palette; none: its own place among the series.
  std::optional<std::size_t> colour{};
};

// A dashed line across the plot at x = value, labelled at its top.
struct PlotReference {
  double x = 0.0;
  std::string label{};
};

struct LinePlot {
  std::string title{};
  std::string x_label{};  // with unit
  std::string y_label{};
  std::vector<PlotSeries> series{};
  std::vector<PlotReference> references{};
  std::optional<AxisRange> x_range{};  // none: exactly the data's
  std::optional<AxisRange> y_range{};  // none: the data's, grown to round numbers
  AxisScale x_scale = AxisScale::kLinear;
  AxisScale y_scale = AxisScale::kLinear;
  int width_px = 640;
  int height_px = 400;
};

// A complete <svg> element that stands alone as a file and within a page; it scales to the width it
// is given and follows the reader's light or dark mode. Pixels are those of its viewBox, `width_px`
// x `height_px`; a point is drawn at the same pixels as the ticks of its coordinates. What lies
// outside a given range is clipped.
std::string svg_from_plot(const LinePlot& plot);

}  // namespace raywalk
