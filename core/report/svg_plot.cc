#include "core/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>

#include "core/report/label_places.h"
#include "core/report/markup.h"
#include "core/report/text_box.h"

namespace raywalk {
namespace {

constexpr int kXTicks = 6;
constexpr int kYTicks = 5;
constexpr double kNoteGapPx = 6.0;
constexpr double kReferenceRowPx = 16.0;
constexpr double kLeastScale = 0.6;  // smaller, its texts could not be read; a page scrolls it
constexpr double kLegendKeyPx = 26.0;
constexpr double kLegendGapPx = 18.0;
constexpr double kLegendRowPx = 18.0;
constexpr std::size_t kColours = 6;

// Okabe and Ito's palette, distinct for colour-blind readers; lightened for dark mode. The class
// limits the style to the plot.
constexpr std::string_view kPlotStyle = R"(<style>
.raywalk-plot { --ink: #1f2933; --soft: #6b7785; --grid: #e3e7eb; --s0: #0072b2; --s1: #d55e00;
  --s2: #009e73; --s3: #b0508a; --s4: #b57d00; --s5: #3a93c4; }
@media screen and (prefers-color-scheme: dark) {
.raywalk-plot { --ink: #e4e8ec; --soft: #98a3af; --grid: #333b44; --s0: #4aa8e0; --s1: #f08a4b;
  --s2: #3cc79b; --s3: #de8fba; --s4: #e8b13a; --s5: #8cccf0; } }
.raywalk-plot text { font: 13px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; fill: var(--ink); }
.raywalk-plot .title { font-size: 15px; font-weight: 600; }
.raywalk-plot .tick, .raywalk-plot .note { fill: var(--soft); }
.raywalk-plot .grid { stroke: var(--grid); stroke-width: 1; }
.raywalk-plot .axis { stroke: var(--soft); stroke-width: 1; fill: none; }
.raywalk-plot .reference { stroke: var(--soft); stroke-width: 1.2; stroke-dasharray: 5 4; }
.raywalk-plot .line { fill: none; stroke-width: 2.2; stroke-linejoin: round; stroke-linecap: round; }
.raywalk-plot .c0 { --c: var(--s0); } .raywalk-plot .c1 { --c: var(--s1); }
.raywalk-plot .c2 { --c: var(--s2); } .raywalk-plot .c3 { --c: var(--s3); }
.raywalk-plot .c4 { --c: var(--s4); } .raywalk-plot .c5 { --c: var(--s5); }
.raywalk-plot .line { stroke: var(--c); } .raywalk-plot .dot { fill: var(--c); }
.raywalk-plot .ring { fill: none; stroke: var(--c); stroke-width: 1.4; pointer-events: all; }
.raywalk-plot a:hover circle { stroke: var(--ink); stroke-width: 2; }
</style>
)";

std::string px(double value) { return plain_number(value, 2); }

bool has_place(double value, AxisScale scale) {
  return std::isfinite(value) && (scale == AxisScale::kLinear || value > 0.0);
}
bool has_place(const PlotPoint& point, const LinePlot& plot) {
  return has_place(point.x, plot.x_scale) && has_place(point.y, plot.y_scale);
}

std::string text_element(double x, double y, std::string_view attributes, std::string_view text) {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" " + std::string(attributes) + ">" +
         escape_markup(text) + "</text>\n";
}

std::string line_element(double x1, double y1, double x2, double y2, std::string_view css_class) {
  return "<line class=\"" + std::string(css_class) + "\" x1=\"" + px(x1) + "\" y1=\"" + px(y1) +
         "\" x2=\"" + px(x2) + "\" y2=\"" + px(y2) + "\"/>\n";
}

// Consecutive classes repeat after kColours.
std::string colour_class(std::size_t colour) {
  return std::string(1, 'c').append(std::to_string(colour % kColours));
}

bool has_line(PlotStyle style) {
  return style == PlotStyle::kLine || style == PlotStyle::kLineAndPoints;
}
bool has_points(PlotStyle style) { return style != PlotStyle::kLine; }

std::string marker(double x, double y, PlotStyle style, const std::string& colour) {
  const char* shape = style == PlotStyle::kRings ? "ring " : "dot ";
  return "<circle class=\"" + (shape + colour) + "\" cx=\"" + px(x) + "\" cy=\"" + px(y) +
         "\" r=\"3.6\"/>\n";
}

// Wraps a marker in its link and tooltip.
std::string marked(const std::string& marker, const PlotMark& mark) {
  const std::string title =
      mark.title.empty() ? "" : "<title>" + escape_markup(mark.title) + "</title>\n";
  if (mark.link.empty()) return "<g>\n" + title + marker + "</g>\n";
  return "<a href=\"" + escape_markup(mark.link) + "\">\n" + title + marker + "</a>\n";
}

AxisRange data_range(const LinePlot& plot,
                     const std::function<double(const PlotPoint&)>& coordinate) {
  AxisRange range{std::numeric_limits<double>::infinity(),
                  -std::numeric_limits<double>::infinity()};
  for (const PlotSeries& series : plot.series) {
    for (const PlotPoint& point : series.points) {
      if (!has_place(point, plot)) continue;
      range.min = std::min(range.min, coordinate(point));
      range.max = std::max(range.max, coordinate(point));
    }
  }
  return range;
}

// The start of a legend entry.
struct LegendPlace {
  double x = 0.0;
  double y = 0.0;
};

// Entries from left to right, wrapped at `width_px`; coordinates are relative to the legend's
// corner.
std::vector<LegendPlace> legend_places(const std::vector<PlotSeries>& all, double width_px) {
  std::vector<LegendPlace> places;
  LegendPlace next;
  for (const PlotSeries& series : all) {
    if (series.name.empty()) {
      places.push_back(next);
      continue;
    }
    const double entry_px = kLegendKeyPx + text_px(series.name);
    if (next.x > 0.0 && next.x + entry_px > width_px) next = {0.0, next.y + kLegendRowPx};
    places.push_back(next);
    next.x += entry_px + kLegendGapPx;
  }
  return places;
}

// The plot area: the picture without title, legend and labels.
struct Frame {
  double left = 64.0;
  double right = 0.0;
  double top = 0.0;
  double bottom = 0.0;
};

class SvgPlot {
 public:
  explicit SvgPlot(const LinePlot& plot)
      : plot_(plot),
        frame_(frame_of(plot)),
        x_(x_axis(plot, frame_)),
        y_(y_axis(plot, frame_)),
        labels_({frame_.left, frame_.top}, {frame_.right, frame_.bottom}) {
    take_places();
  }

  std::string draw() {
    open();
    draw_grid();
    draw_references();
    draw_series();
    draw_frame_and_labels();
    draw_legend();
    svg_ += "</svg>\n";
    return svg_;
  }

 private:
  static double legend_top(const LinePlot& plot) { return plot.title.empty() ? 10.0 : 34.0; }

  static Frame frame_of(const LinePlot& plot) {
    Frame frame;
    frame.right = plot.width_px - 18.0;
    frame.bottom = plot.height_px - 50.0;
    const std::vector<LegendPlace> places = legend_places(plot.series, frame.right - frame.left);
    const double legend_px = places.empty() ? 0.0 : places.back().y + kLegendRowPx;
    frame.top = legend_top(plot) + legend_px + 8.0;
    int rows = 0;
    for (const ReferenceLabel& label : labels_of(plot, frame)) rows = std::max(rows, label.row + 1);
    frame.top += rows * kReferenceRowPx;
    return frame;
  }

  // The labels of the references within the plot; they depend on its sides only.
  static std::vector<ReferenceLabel> labels_of(const LinePlot& plot, const Frame& frame) {
    if (plot.references.empty()) return {};
    const PlotAxis axis = x_axis(plot, frame);
    std::vector<std::pair<double, std::string>> lines;
    for (const PlotReference& reference : plot.references) {
      if (!has_place(reference.x, plot.x_scale)) continue;
      const double x = axis.pixel(reference.x);
      if (x >= frame.left && x <= frame.right) lines.emplace_back(x, reference.label);
    }
    std::ranges::sort(lines);
    return reference_labels(lines, frame.left, frame.right);
  }

  static PlotAxis x_axis(const LinePlot& plot, const Frame& frame) {
    const AxisRange range =
        plot.x_range.value_or(data_range(plot, [](const PlotPoint& point) { return point.x; }));
    return {range, frame.left, frame.right, kXTicks, plot.x_scale};
  }

  static PlotAxis y_axis(const LinePlot& plot, const Frame& frame) {
    const AxisRange data = data_range(plot, [](const PlotPoint& point) { return point.y; });
    const AxisRange range =
        plot.y_range ? *plot.y_range : rounded_range(data, kYTicks, plot.y_scale);
    return {range, frame.bottom, frame.top, kYTicks, plot.y_scale};
  }

  void open() {
    const std::string width = std::to_string(plot_.width_px);
    const std::string height = std::to_string(plot_.height_px);
    svg_ +=
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"raywalk-plot\" role=\"img\" width=\"" +
        width + "\" height=\"" + height + "\" viewBox=\"0 0 " + width + " " + height +
        "\" style=\"max-width: 100%; min-width: " + px(kLeastScale * plot_.width_px) +
        "px; height: auto\">\n";
    const std::string& name = plot_.title.empty() ? plot_.y_label : plot_.title;
    svg_ += "<title>" + escape_markup(name) + "</title>\n";
    svg_ += kPlotStyle;
  }

  void draw_grid() {
    for (const double tick : x_.ticks()) {
      const double x = x_.pixel(tick);
      svg_ += line_element(x, frame_.top, x, frame_.bottom, "grid");
      svg_ += text_element(x, frame_.bottom + 18.0, "class=\"tick\" text-anchor=\"middle\"",
                           x_.label(tick));
    }
    for (const double tick : y_.ticks()) {
      const double y = y_.pixel(tick);
      svg_ += line_element(frame_.left, y, frame_.right, y, "grid");
      svg_ += text_element(frame_.left - 8.0, y + 4.0, "class=\"tick\" text-anchor=\"end\"",
                           y_.label(tick));
    }
  }

  // Above the plot, where no data can lie under them.
  void draw_references() {
    for (const ReferenceLabel& label : labels_of(plot_, frame_)) {
      const double baseline = frame_.top - 4.0 - label.row * kReferenceRowPx;
      svg_ += line_element(label.x, baseline - kFontPx, label.x, frame_.bottom, "reference");
      svg_ += text_element(label.x + (label.right ? kNoteGapPx : -kNoteGapPx), baseline,
                           label.right ? "class=\"note\" text-anchor=\"start\""
                                       : "class=\"note\" text-anchor=\"end\"",
                           label.text);
    }
  }

  // One <polyline> for each run of finite points.
  void draw_line(const PlotSeries& series, const std::string& colour) {
    std::string run;
    const auto end_run = [&] {
      if (!run.empty()) {
        svg_ += "<polyline class=\"line " + colour + "\" points=\"" + run + "\"/>\n";
      }
      run.clear();
    };
    for (const PlotPoint& point : series.points) {
      if (!has_place(point, plot_)) {
        end_run();
        continue;
      }
      if (!run.empty()) run += ' ';
      run += px(x_.pixel(point.x)) + "," + px(y_.pixel(point.y));
    }
    end_run();
  }

  void draw_points(const PlotSeries& series, const std::string& colour) {
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      if (!has_place(series.points[i], plot_)) continue;
      const double x = x_.pixel(series.points[i].x);
      const double y = y_.pixel(series.points[i].y);
      const std::string drawn = marker(x, y, series.style, colour);
      if (i < series.marks.size()) {
        draw_label(x, y, series.marks[i].label);
        svg_ += marked(drawn, series.marks[i]);
      } else {
        svg_ += drawn;
      }
    }
  }

  // A label without a free place is omitted, as overlapping labels are unreadable.
  void draw_label(double x, double y, const std::string& label) {
    if (label.empty()) return;
    const auto place = labels_.place({x, y}, label);
    if (!place) return;
    svg_ +=
        text_element(place->left, place->baseline, "class=\"note\" text-anchor=\"start\"", label);
  }

  // What labels must keep clear of, before the first is placed.
  void take_places() {
    for (const PlotSeries& series : plot_.series) {
      std::vector<PixelPoint> run;
      for (const PlotPoint& point : series.points) {
        if (!has_place(point, plot_)) {
          if (has_line(series.style)) labels_.add_line(run);
          run.clear();
          continue;
        }
        run.push_back({x_.pixel(point.x), y_.pixel(point.y)});
        if (has_points(series.style)) labels_.add_point(run.back());
      }
      if (has_line(series.style)) labels_.add_line(run);
    }
  }

  // A nested <svg> clips to its own rectangle; its viewBox keeps the picture's coordinates.
  void draw_series() {
    const std::string box = px(frame_.left) + " " + px(frame_.top) + " " +
                            px(frame_.right - frame_.left) + " " + px(frame_.bottom - frame_.top);
    svg_ += "<svg x=\"" + px(frame_.left) + "\" y=\"" + px(frame_.top) + "\" width=\"" +
            px(frame_.right - frame_.left) + "\" height=\"" + px(frame_.bottom - frame_.top) +
            "\" viewBox=\"" + box + "\"" + (clips() ? "" : " overflow=\"visible\"") + ">\n";
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      const PlotSeries& series = plot_.series[i];
      const std::string colour = colour_class(series.colour.value_or(i));
      if (has_line(series.style)) draw_line(series, colour);
      if (has_points(series.style)) draw_points(series, colour);
    }
    svg_ += "</svg>\n";
  }

  // Without a given range nothing lies outside, and dots on the frame should not be clipped.
  bool clips() const { return plot_.x_range.has_value() || plot_.y_range.has_value(); }

  void draw_frame_and_labels() {
    svg_ += "<path class=\"axis\" d=\"M" + px(frame_.left) + " " + px(frame_.top) + "V" +
            px(frame_.bottom) + "H" + px(frame_.right) + "\"/>\n";
    svg_ += text_element(0.5 * (frame_.left + frame_.right), plot_.height_px - 10.0,
                         "text-anchor=\"middle\"", plot_.x_label);
    const double middle = 0.5 * (frame_.top + frame_.bottom);
    svg_ += text_element(16.0, middle,
                         "text-anchor=\"middle\" transform=\"rotate(-90 16 " + px(middle) + ")\"",
                         plot_.y_label);
    if (!plot_.title.empty()) {
      svg_ += text_element(frame_.left, 22.0, "class=\"title\"", plot_.title);
    }
  }

  void draw_legend() {
    const std::vector<LegendPlace> places = legend_places(plot_.series, frame_.right - frame_.left);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double x = frame_.left + places[i].x;
      const double y = legend_top(plot_) + places[i].y + 8.0;
      const PlotSeries& series = plot_.series[i];
      if (series.name.empty()) continue;
      const std::string colour = colour_class(series.colour.value_or(i));
      if (has_line(series.style)) svg_ += line_element(x, y, x + 18.0, y, "line " + colour);
      if (has_points(series.style)) svg_ += marker(x + 9.0, y, series.style, colour);
      svg_ += text_element(x + kLegendKeyPx, y + 4.0, "text-anchor=\"start\"", series.name);
    }
  }

  const LinePlot& plot_;
  Frame frame_;
  PlotAxis x_;
  PlotAxis y_;
  LabelPlaces labels_;
  std::string svg_;
};

}  // namespace

std::string svg_from_plot(const LinePlot& plot) { return SvgPlot(plot).draw(); }

}  // namespace raywalk
