#include "build_lf/require/requirement_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "build_lf/require/floor_plan.h"
#include "build_lf/require/scene_plots.h"
#include "core/base/counted.h"
#include "core/geometry/spacing.h"
#include "core/report/svg_plot.h"
#include "core/room/connection_errors.h"
#include "core/room/connection_model.h"

namespace raywalk::build_lf {
namespace {

constexpr int kPoints = 80;
constexpr double kCentimetres = 100.0;
constexpr std::array kGhostLayers{1, 4, 16};

LinePlot plot_of(const char* x_label, const char* y_label) {
  LinePlot plot;
  plot.x_label = x_label;
  plot.y_label = y_label;
  return plot;
}

double tolerance_rad(const RoomRequirements& r) {
  return angle_of_pixels(r.tolerance_px, r.storage.panorama_width_px);
}

// Number of layers over the distance d_p from the line, up to the far side of the cell.
std::string layers_plot(const RoomRequirements& r) {
  LinePlot plot = plot_of("distance from the line / m", "depth layers");
  PlotSeries curve{.name = fmt::format("for {:g} px", r.tolerance_px)};
  // Up to the far side of a cell; beyond it rays graze near surfaces and the count diverges.
  const double farthest_m = 2.0 * r.storage.reach_m;
  int most = 1;
  for (int i = 1; i <= kPoints; ++i) {
    const double d_p_m = farthest_m * i / kPoints;
    const int layers = layers_for_tolerance(r.layers.range(), d_p_m, tolerance_rad(r));
    most = std::max(most, layers);
    curve.points.push_back({d_p_m, static_cast<double>(layers)});
  }
  plot.series = {std::move(curve)};
  plot.references = {{r.storage.reach_m, "middle of a cell"}};
  plot.x_range = AxisRange{0.0, farthest_m};
  plot.y_range = AxisRange{0.0, 1.08 * most};
  return svg_from_plot(plot);
}

// Ghost (distance between the two copies of a source, in pixels) over the station spacing, for
// different knowledge of the distances.
std::string ghost_plot(const RoomRequirements& r) {
  LinePlot plot = plot_of("spacing of the stations / cm", "ghost / px");
  const OmegaRange scene = r.layers.range();
  const double widest_m = 2.0 * r.spacing.captured_median_m;
  const double pixel_rad = angle_of_pixels(1.0, r.storage.panorama_width_px);
  const auto add = [&](const std::string& name, auto ghost_rad) {
    PlotSeries series{.name = name};
    for (int i = 0; i <= kPoints; ++i) {
      const double spacing_m = widest_m * i / kPoints;
      series.points.push_back({kCentimetres * spacing_m, ghost_rad(spacing_m) / pixel_rad});
    }
    plot.series.push_back(std::move(series));
  };
  add("no depth", [&](double s) { return largest_ghost_without_depth(scene, s); });
  for (const int layers : kGhostLayers) {
    add(counted(static_cast<size_t>(layers), "layer"),
        [&](double s) { return largest_ghost(scene, omega_error_of_layers(scene, layers), s); });
  }
  if (r.distance.omega_error_per_m) {
    add("distances",
        [&](double s) { return largest_ghost(scene, *r.distance.omega_error_per_m, s); });
  }
  const double widest_cm = kCentimetres * widest_m;
  plot.series.push_back({.name = fmt::format("tolerance {:g} px", r.tolerance_px),
                         .points = {{0.0, r.tolerance_px}, {widest_cm, r.tolerance_px}}});
  plot.references = {{kCentimetres * r.spacing.captured_median_m, "captured"}};
  plot.x_range = AxisRange{0.0, widest_cm};
  plot.y_range = AxisRange{0.0, 8.0 * r.tolerance_px};
  return svg_from_plot(plot);
}

// E_t over k for the room's distances. The room must have a cell.
std::string model_plot(const Room& room, const RoomRequirements& r) {
  LinePlot plot = plot_of("k / degrees", "E_t, equation (6)");
  PlotSeries series{.name = "model E_t"};
  const ConnectionErrorCurve curve = connection_model(room).curve;
  for (size_t i = 0; i < curve.total.size(); ++i) {
    series.points.push_back(
        {ConnectionErrorCurve::kMinDeg + static_cast<double>(i), curve.total[i]});
  }
  plot.series = {std::move(series)};
  plot.references = {
      {*r.connection.model_k_deg, fmt::format("least: {:g}", *r.connection.model_k_deg)}};
  return svg_from_plot(plot);
}

// Measured E_connect over k, one curve per generation.
std::string measured_connection_plot(const Room& room) {
  LinePlot plot = plot_of("k / degrees", "E_connect / squared 8-bit levels");
  for (const ConnectionErrorMeasurement& each : read_connection_errors(room.directory())) {
    if (!least_error(each)) continue;
    PlotSeries series{.name = each.generation, .style = PlotStyle::kLineAndPoints};
    for (const ConnectionErrorAtK& row : each.rows) {
      series.points.push_back({row.k_deg, row.e_connect_common});  // NaN leaves a gap
    }
    plot.series.push_back(std::move(series));
  }
  return svg_from_plot(plot);
}

}  // namespace

RequirementFigures requirement_figures(const Room& room, const RoomRequirements& r,
                                       const KeptStations& needed) {
  RequirementFigures figures;
  figures.directions =
      svg_figure(direction_map_svg(r.distance),
                 "Nearest surface (1 % quantile) per field of 15 x 15 degrees, in metres, laid out "
                 "as a panorama: longitude across, latitude up.");
  figures.around = {
      svg_figure(floor_plan_svg(room, needed),
                 "From above: surfaces near eye level (grey), stations that are needed with "
                 "distances (filled) and those that could be left out (rings)."),
      svg_figure(horizon_svg(r.distance),
                 "Around the horizon, within 15 degrees: median (line), and from the nearest 1 % "
                 "to the farthest (band).")};
  figures.layers = svg_figure(layers_plot(r), "Depth layers over the distance from the line.");
  figures.ghosts =
      svg_figure(ghost_plot(r), "Distance between the two copies of the nearest source.");
  if (r.connection.model_k_deg) {
    figures.connection.push_back(
        svg_figure(model_plot(room, r), "The model E_t over the room's distances."));
  }
  if (!r.connection.measured.empty()) {
    figures.connection.push_back(
        svg_figure(measured_connection_plot(room),
                   "Measured E_connect, over the corners readable at every k."));
  }
  return figures;
}

}  // namespace raywalk::build_lf
