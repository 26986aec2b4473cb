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

// kRings: hollow points, for less important data.
enum class PlotStyle { kLine, kPoints, kLineAndPoints, kRings };

// Link and texts of a point.
struct PlotMark {
  std::string link{};   // target of the link; empty: none
  std::string title{};  // tooltip
  std::string label{};  // printed beside it if there is room
};

struct PlotSeries {
  std::string name{};  // in the legend; empty: not listed
  // A point that is not finite, or not positive on a logarithmic axis, leaves a gap.
  std::vector<PlotPoint> points{};
  PlotStyle style = PlotStyle::kLine;
  std::vector<PlotMark> marks{};  // of each point; empty: none
  // Index into the colour palette; none: the index of the series.
  std::optional<std::size_t> colour{};
};

// A dashed line across the plot at x = value, labelled above the plot.
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
  // Such that texts can still be read where a plot is as wide as a phone, or half as wide as paper.
  int width_px = 480;
  int height_px = 320;
};

// A complete <svg> element, valid as a file and within a page, that scales to the available width
// and follows the reader's light or dark mode. Its viewBox is `width_px` x `height_px`; points and
// ticks use the same PlotAxis. Data outside a given range is clipped.
std::string svg_from_plot(const LinePlot& plot);

}  // namespace raywalk
