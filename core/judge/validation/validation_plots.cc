#include "core/judge/validation/validation_plots.h"

#include <cmath>

#include "core/report/svg_plot.h"

namespace raywalk {
namespace {

constexpr double kCentimetres = 100.0;
constexpr int kPlotWidth_px = 560;
constexpr int kPlotHeight_px = 340;
constexpr double kHeadroom = 1.2;  // above the largest value of a plot with a given scale

std::string mode_name(const Validation& validation, std::size_t mode) {
  return generation_name(validation.modes[mode].options.generation);
}

const std::vector<QuarterScore>& quarters_at(const Validation& validation, std::size_t truth,
                                             std::size_t mode) {
  return validation.views[truth * validation.modes.size() + mode].quarters;
}

LinePlot distance_plot(const std::string& y_label) {
  LinePlot plot;
  plot.x_label = "distance from the line / cm";
  plot.y_label = y_label;
  plot.width_px = kPlotWidth_px;
  plot.height_px = kPlotHeight_px;
  return plot;
}

// Over the corners readable at every k where these are enough, so that the curve compares the k.
double error_of(const ConnectError& measured, const ConnectErrorRow& row) {
  return measured.common_share >= kLeastCommonShare ? row.e_connect_common : row.e_connect;
}

LinePlot plot_over_k(const Validation& validation) {
  LinePlot plot;
  plot.x_label = "k / degrees";
  plot.y_label = "E_connect / squared 8-bit levels";
  plot.width_px = kPlotWidth_px;
  plot.height_px = kPlotHeight_px;
  plot.references = {{45.0, "LFU"}, {90.0, "Ray-space360"}};
  for (const ConnectError& measured : validation.connection_error) {
    PlotSeries series{.name = generation_name(measured.generation),
                      .style = PlotStyle::kLineAndPoints};
    for (const ConnectErrorRow& row : measured.rows) {
      series.points.push_back({row.k_deg, error_of(measured, row)});  // NaN leaves a gap
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

std::optional<std::size_t> initial_mode(const Validation& validation) {
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    if (validation.modes[mode].options.generation == Generation::kInitial) return mode;
  }
  return std::nullopt;
}

std::string metric_plot(const Validation& validation, const QuarterMetric& metric) {
  LinePlot plot = distance_plot(metric.axis);
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    PlotSeries series{.name = mode_name(validation, mode), .style = PlotStyle::kPoints};
    for (std::size_t truth = 0; truth < validation.truths.size(); ++truth) {
      for (const QuarterScore& score : quarters_at(validation, truth, mode)) {
        series.points.push_back({kCentimetres * score.line_distance_m, score.*metric.member});
      }
    }
    plot.series.push_back(std::move(series));
  }
  return svg_from_plot(plot);
}

std::string gain_plot(const Validation& validation, const QuarterMetric& metric) {
  LinePlot plot = distance_plot(std::string("gain in ") + metric.axis);
  const std::size_t initial = initial_mode(validation).value();
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    PlotSeries series{.name = mode_name(validation, mode), .style = PlotStyle::kPoints};
    for (std::size_t truth = 0; truth < validation.truths.size(); ++truth) {
      const std::vector<QuarterScore>& before = quarters_at(validation, truth, initial);
      const std::vector<QuarterScore>& after = quarters_at(validation, truth, mode);
      for (std::size_t i = 0; i < after.size(); ++i) {
        series.points.push_back({kCentimetres * after[i].line_distance_m,
                                 after[i].*metric.member - before[i].*metric.member});
      }
    }
    plot.series.push_back(std::move(series));
  }
  return svg_from_plot(plot);
}

std::string connection_error_plot(const Validation& validation) {
  return svg_from_plot(plot_over_k(validation));
}

std::optional<std::string> corrected_connection_error_plot(const Validation& validation) {
  double largest = std::nan("");
  bool has_initial = false;
  for (const ConnectError& measured : validation.connection_error) {
    if (measured.generation == Generation::kInitial) {
      has_initial = true;
    } else {
      for (const ConnectErrorRow& row : measured.rows) {
        largest = std::fmax(largest, error_of(measured, row));
      }
    }
  }
  if (!has_initial || !(largest > 0.0)) return std::nullopt;
  LinePlot plot = plot_over_k(validation);
  plot.y_range = AxisRange{0.0, kHeadroom * largest};
  return svg_from_plot(plot);
}

}  // namespace raywalk
