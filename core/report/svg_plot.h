// Line plots as SVG: several series over two linear axes, with ticks, a legend and reference lines.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/report/plot_axis.h"

namespace raywalk {

struct PlotPoint {
  double x = 0.0;
  double y = 0.0;
};

enum class PlotStyle { kLine, kPoints, kLineAndPoints };

struct PlotSeries {
  std::string name{};               // in the legend
  std::vector<PlotPoint> points{};  // a point that is not finite leaves a gap
  PlotStyle style = PlotStyle::kLine;
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
  int width_px = 640;
  int height_px = 400;
};

// A complete <svg> element that stands alone as a file and within a page; it scales to the width it
// is given and follows the reader's light or dark mode. Pixels are those of its viewBox, `width_px`
// x `height_px`; a point is drawn at the same pixels as the ticks of its coordinates. What lies
// outside a given range is clipped.
std::string svg_from_plot(const LinePlot& plot);

}  // namespace raywalk
