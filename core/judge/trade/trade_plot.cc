#include "core/judge/trade/trade_plot.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/report/json_scope.h"
#include "core/report/svg_plot.h"
#include "core/view/view_options.h"

namespace raywalk {
namespace {

constexpr int kPlotWidth_px = 1150;
constexpr int kPlotHeight_px = 560;
constexpr double kRoom = 1.25;  // margin beside the fastest and the slowest setting, as a factor
constexpr std::size_t kFrontColour = 3;  // beside those of the generations

PlotPoint point_of(const JsonScope& setting) {
  return {setting.number("ratio"), setting.number("psnr_db")};
}

PlotSeries series_of(const JsonScope& trade, Generation generation, bool on_front) {
  const std::string name = generation_name(generation);
  PlotSeries series{.name = on_front ? name : "",
                    .style = on_front ? PlotStyle::kPoints : PlotStyle::kRings,
                    .colour = static_cast<std::size_t>(generation)};
  for (const JsonScope& setting : trade.entries("settings")) {
    if (setting.text("{generation}") != name) continue;
    if (setting.holds("pareto.psnr_db") != on_front) continue;
    series.points.push_back(point_of(setting));
    series.marks.push_back(
        {.link = setting.text("#setting-{number}"),
         .title = setting.text("{number}: {name}{disturbed: (time disturbed)|}\n"
                               "{ms:.2f ms}, {ratio:.2f} times a remap, {psnr_db:.2f dB}"),
         .label = setting.text(on_front ? "{number}" : "")});
  }
  return series;
}

// The best PSNR within each time, up to `end_ratio`.
PlotSeries front_of(const JsonScope& trade, double end_ratio) {
  PlotSeries series{.name = "front: the best PSNR within the time", .colour = kFrontColour};
  for (const JsonScope& setting : trade.entries("front")) {
    const PlotPoint point = point_of(setting);
    if (!series.points.empty()) series.points.push_back({point.x, series.points.back().y});
    series.points.push_back(point);
  }
  series.points.push_back({end_ratio, series.points.back().y});
  return series;
}

AxisRange ratios_of(const JsonScope& trade) {
  std::vector<double> ratios;
  for (const JsonScope& setting : trade.entries("settings")) {
    ratios.push_back(setting.number("ratio"));
  }
  const auto [least, most] = std::ranges::minmax(ratios);
  return {least / kRoom, most * kRoom};
}

}  // namespace

HtmlFigure trade_plot(const nlohmann::ordered_json& document) {
  const JsonScope trade(document);
  LinePlot plot{
      .title = "PSNR over the time of a view",
      .x_label = trade.text("time of a view, as a multiple of one cv::remap ({remap_ms:.2f ms})"),
      .y_label = "PSNR / dB",
      .x_range = ratios_of(trade),
      .x_scale = AxisScale::kLogarithmic,
      .width_px = kPlotWidth_px,
      .height_px = kPlotHeight_px};
  plot.series.push_back(front_of(trade, plot.x_range->max));
  constexpr std::array kGenerations{Generation::kInitial, Generation::kHlfVd,
                                    Generation::kTwoSided};
  for (const bool on_front : {false, true}) {
    for (const Generation generation : kGenerations) {
      plot.series.push_back(series_of(trade, generation, on_front));
    }
  }
  return svg_figure(svg_from_plot(plot), "");
}

HtmlFigure held_out_plot(const nlohmann::ordered_json& document) {
  PlotSeries series{.style = PlotStyle::kPoints};
  for (const JsonScope& setting : JsonScope(document).entries("settings")) {
    series.points.push_back({setting.number("psnr_db"), setting.number("held_out_psnr_db")});
    series.marks.push_back(
        {.link = setting.text("#setting-{number}"), .title = setting.text("{name}")});
  }
  return svg_figure(svg_from_plot({.title = "Each point is a setting",
                                   .x_label = "PSNR against the truth, dB",
                                   .y_label = "PSNR of held-out stations, dB",
                                   .series = {series}}),
                    "");
}

}  // namespace raywalk
