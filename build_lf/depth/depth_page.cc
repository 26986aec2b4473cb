#include "build_lf/depth/depth_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "build_lf/depth/station_image.h"
#include "core/base/counted.h"
#include "core/report/html_page.h"
#include "core/report/svg_plot.h"

namespace raywalk::build_lf {
namespace {

// [theta][phi] values as an upright picture.
template <typename T>
cv::Mat upright(const std::vector<T>& values, PanoramaSize size, int type) {
  const cv::Mat columns(size.width, size.height, type, const_cast<T*>(values.data()));
  return columns.t();
}

cv::Mat distance_picture(const InverseDistanceMap& map) {
  std::vector<float> sorted = map.omega;
  const auto near = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 999 / 1000);
  std::nth_element(sorted.begin(), near, sorted.end());
  cv::Mat levels;
  upright(map.omega, map.size, CV_32FC1).convertTo(levels, CV_8U, 255.0 / std::max(1e-9f, *near));
  cv::Mat picture;
  cv::applyColorMap(levels, picture, cv::COLORMAP_TURBO);
  return picture;
}

// Grey for confident pixels, red below kMinConfidence.
cv::Mat confidence_picture(const InverseDistanceMap& map) {
  const cv::Mat confidence = upright(map.confidence, map.size, CV_8UC1);
  cv::Mat picture;
  cv::cvtColor(confidence, picture, cv::COLOR_GRAY2BGR);
  picture.setTo(cv::Scalar(40, 40, 220), confidence < kMinConfidence);
  return picture;
}

cv::Mat photograph(const Room& room, const InverseDistanceMap& map) {
  cv::Mat picture;
  cv::cvtColor(station_image(room, map.station, map.size).t(), picture, cv::COLOR_RGB2BGR);
  return picture;
}

void add_maps(const Room& room, const std::vector<InverseDistanceMap>& shown, HtmlPage* page) {
  page->add_section("Distances and confidence");
  page->add_paragraph(
      "Inverse distance from blue (far) to red (near); confidence from black to white, and red "
      "where it is low (the share above is of the solid angle of all maps): there the renderer "
      "prefers other maps. Expect it on plain walls, "
      "panes and mirrors, at silhouettes, and along a rail that no other line crosses.");
  for (const InverseDistanceMap& map : shown) {
    const std::string where = fmt::format(
        "line {}, station {}", room.grid().lines[static_cast<size_t>(map.station.line)].id,
        map.station.station);
    page->add_figures(
        {picture_figure(photograph(room, map), EmbeddedFormat::kJpeg, "panorama", where),
         picture_figure(distance_picture(map), EmbeddedFormat::kJpeg, "inverse distance",
                        where + ": inverse distance"),
         picture_figure(confidence_picture(map), EmbeddedFormat::kJpeg, "confidence",
                        where + ": confidence")});
  }
}

void add_stations(const DepthSummary& summary, HtmlPage* page) {
  LinePlot plot{.title = "Confidence along the lines",
                .x_label = "station",
                .y_label = "mean confidence",
                .y_range = AxisRange{0.0, 1.0}};
  for (const MapSummary& map : summary.maps) {
    if (plot.series.empty() || plot.series.back().name != map.line) {
      plot.series.push_back({.name = map.line, .style = PlotStyle::kLineAndPoints});
    }
    plot.series.back().points.push_back({static_cast<double>(map.station), map.mean_confidence});
  }
  page->add_section("Stations");
  page->add_figures({svg_figure(svg_from_plot(plot), "Mean over the sphere of each map")});
}

void add_left_out(const DepthSummary& summary, HtmlPage* page) {
  page->add_section("Left out");
  page->add_paragraph(
      "People, cars and other things that moved: what these stations show and the stations around "
      "them contradict. Views read the place from other stations, and use these pixels only where "
      "no other station sees it. raywalk-build-lf depth --keep-moving keeps them.");
  HtmlTable table{.header = {"line", "station", "file", "left out"}};
  for (const LeftOutSummary& station : summary.left_out) {
    table.rows.push_back({{station.line},
                          {fmt::format("{}", station.station)},
                          {station.file},
                          {fmt::format("{:.2f} %", 100.0 * station.share)}});
  }
  page->add_table(table);
}

PlotSeries wrong_series(const std::string& name, const std::vector<ConfidenceBand>& bands) {
  PlotSeries series{.name = name, .style = PlotStyle::kLineAndPoints};
  for (const ConfidenceBand& band : bands) {
    series.points.push_back({band.confidence, band.wrong_share});
  }
  return series;
}

HtmlTable table_of(const std::vector<ConfidenceBand>& bands) {
  HtmlTable table{.header = {"confidence", "pixels", "off by more than 1 px", "median error, px"}};
  for (const ConfidenceBand& band : bands) {
    table.rows.push_back({{fmt::format("{:.2f}", band.confidence)},
                          {fmt::format("{}", band.pixels)},
                          {fmt::format("{:.1f} %", 100.0 * band.wrong_share)},
                          {fmt::format("{:.2f}", band.median_error_px)}});
  }
  return table;
}

void add_truth(const TruthComparison& truth, HtmlPage* page) {
  page->add_section("Comparison with the given distances");
  page->add_paragraph(
      fmt::format("{}: {}.", counted(static_cast<std::size_t>(truth.maps), "map"), text_of(truth)));
  LinePlot plot{.title = "Low confidence predicts error",
                .x_label = "confidence",
                .y_label = "share of pixels off by more than 1 px",
                .x_range = AxisRange{0.0, 1.0},
                .y_range = AxisRange{0.0, 1.0}};
  plot.series.push_back(wrong_series("all pixels", truth.calibration));
  if (!truth.completed.empty()) {
    plot.series.push_back(wrong_series("completed pixels", truth.completed));
  }
  page->add_figures({svg_figure(svg_from_plot(plot), "Calibration of the confidence")});
  page->add_table(table_of(truth.calibration));
  if (truth.completed.empty()) return;
  page->add_paragraph("Of these, the pixels completed from their surroundings:");
  page->add_table(table_of(truth.completed));
}

}  // namespace

std::string depth_page(const Room& room, const DepthSummary& summary,
                       const std::vector<InverseDistanceMap>& shown) {
  HtmlPage page("Distances of " + summary.room,
                fmt::format("{} maps by {} at {} x {}", summary.maps.size(), summary.method,
                            summary.size.width, summary.size.height));
  page.add_facts(
      {{"maps", fmt::format("{} of {} stations", summary.maps.size(), summary.stations)},
       {"longest baseline", fmt::format("{:.3g} m", summary.reach_m)},
       {"layers", fmt::format("{}", summary.layers)},
       {fmt::format("confidence below {:.2f}", kMinConfidence / 255.0),
        fmt::format("{:.1f} %", 100.0 * summary.low_confidence_share())},
       {"left out, as it moved", summary.leave_out_moving
                                     ? fmt::format("{:.2g} %", 100.0 * summary.left_out_share())
                                     : "not looked for"},
       {"in use by views", summary.distances},
       {"time", fmt::format("{:.0f} s", summary.seconds)},
       {"memory", fmt::format("{:.0f} MB", summary.peak_memory_mb)},
       {"gains differ by", fmt::format("{:.1f} %", 100.0 * summary.gain_spread)}});
  if (summary.gains) {
    page.add_section("Gains");
    page.add_paragraph("By the surfaces that several stations see, " + text_of(*summary.gains) +
                       ".");
  }
  if (!summary.warnings.empty()) {
    page.add_section("Warnings");
    for (const std::string& warning : summary.warnings) page.add_paragraph(warning);
  }
  add_maps(room, shown, &page);
  add_stations(summary, &page);
  if (!summary.left_out.empty()) add_left_out(summary, &page);
  if (summary.truth) add_truth(*summary.truth, &page);
  return page.html();
}

}  // namespace raywalk::build_lf
