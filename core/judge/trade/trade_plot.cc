#include "core/judge/trade/trade_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/report/svg_plot.h"

namespace raywalk {
namespace {

constexpr int kPlotWidth_px = 1150;
constexpr int kPlotHeight_px = 560;
constexpr double kRoom = 1.25;  // margin beside the fastest and the slowest setting, as a factor
constexpr std::size_t kFrontColour = 3;  // beside those of the generations

PlotPoint point_of(const MeasuredSetting& setting) {
  return {setting.measured.time.ratio, setting.measured.scores.psnr_db};
}

PlotMark mark_of(const MeasuredSetting& setting, std::size_t index, bool numbered) {
  return {.link = "#" + anchor_of(index),
          .title = fmt::format("{}: {}\n{:.2f} ms, {:.2f} times a remap, {:.2f} dB", index + 1,
                               marked_name(setting), setting.measured.time.ms,
                               setting.measured.time.ratio, setting.measured.scores.psnr_db),
          .label = numbered ? std::to_string(index + 1) : ""};
}

PlotSeries series_of(const Trade& trade, Generation generation, bool on_front) {
  PlotSeries series{.style = on_front ? PlotStyle::kPoints : PlotStyle::kRings,
                    .colour = static_cast<std::size_t>(generation)};
  for (std::size_t i = 0; i < trade.settings.size(); ++i) {
    const MeasuredSetting& setting = trade.settings[i];
    const bool wanted =
        setting.setting.mode.options.generation == generation && setting.pareto.psnr_db == on_front;
    if (!wanted) continue;
    series.points.push_back(point_of(setting));
    series.marks.push_back(mark_of(setting, i, on_front));
  }
  return series;
}

// The best PSNR within each time, up to `end_ratio`.
PlotSeries front_of(const Trade& trade, double end_ratio) {
  PlotSeries series{.name = "front: the best PSNR within the time", .colour = kFrontColour};
  for (const std::size_t i : psnr_front(trade)) {
    const PlotPoint point = point_of(trade.settings[i]);
    if (!series.points.empty()) series.points.push_back({point.x, series.points.back().y});
    series.points.push_back(point);
  }
  series.points.push_back({end_ratio, series.points.back().y});
  return series;
}

AxisRange ratios_of(const Trade& trade) {
  const auto [least, most] = std::ranges::minmax(
      trade.settings, {},
      [](const MeasuredSetting& setting) { return setting.measured.time.ratio; });
  return {least.measured.time.ratio / kRoom, most.measured.time.ratio * kRoom};
}

}  // namespace

std::string anchor_of(std::size_t setting) { return fmt::format("setting-{}", setting + 1); }

std::string trade_plot(const Trade& trade) {
  LinePlot plot{.title = "PSNR over the time of a view",
                .x_label = fmt::format("time of a view, as a multiple of one cv::remap ({:.2f} ms)",
                                       trade.remap_ms),
                .y_label = "PSNR / dB",
                .x_range = ratios_of(trade),
                .x_scale = AxisScale::kLogarithmic,
                .width_px = kPlotWidth_px,
                .height_px = kPlotHeight_px};
  plot.series.push_back(front_of(trade, plot.x_range->max));
  constexpr std::array kGenerations{Generation::kInitial, Generation::kHlfVd,
                                    Generation::kTwoSided};
  for (const Generation generation : kGenerations) {
    plot.series.push_back(series_of(trade, generation, false));
  }
  for (const Generation generation : kGenerations) {
    PlotSeries series = series_of(trade, generation, true);
    series.name = generation_name(generation);
    plot.series.push_back(std::move(series));
  }
  return svg_from_plot(plot);
}

}  // namespace raywalk
