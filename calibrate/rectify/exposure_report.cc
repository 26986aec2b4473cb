#include "calibrate/rectify/exposure_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/report/svg_plot.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

bool is_corrected(const LightGain& gain) { return gain != LightGain{1.0, 1.0, 1.0}; }

std::size_t corrected_frames(const ExposureResult& exposure) {
  return static_cast<std::size_t>(
      std::count_if(exposure.gains.begin(), exposure.gains.end(), is_corrected));
}

std::size_t measured_frames(const ExposureResult& exposure) {
  return static_cast<std::size_t>(
      std::count(exposure.measured.begin(), exposure.measured.end(), true));
}

// Photographic stops (factors of two), mean of the colours.
double mean_stops(const LightGain& gain) {
  return (std::log2(gain[0]) + std::log2(gain[1]) + std::log2(gain[2])) / 3.0;
}

// Of a logarithm of light.
std::string percent(double log_light) {
  const double rounded = std::round(1e4 * std::expm1(log_light)) / 100.0;
  return fmt::format("{:.2f} %", rounded + 0.0);
}

const char* model_text(ExposureModel model) {
  switch (model) {
    case ExposureModel::kEqual:
      return "all frames alike";
    case ExposureModel::kLines:
      return "one value per line";
    case ExposureModel::kDrift:
      return "steady drift along each line";
    case ExposureModel::kStations:
      return "one value per frame";
  }
  return "";
}

const std::string& name_of(const CaptureSet& set, int frame) {
  return set.frames[static_cast<std::size_t>(frame)].name;
}

HtmlTable models_table(const CaptureSet& set, const ExposureResult& exposure) {
  HtmlTable table{.caption = "Which differences the measurement shows",
                  .header = {"light", "assumed", "largest deviation / standard errors", "at",
                             "allowed by chance", "verdict"}};
  for (int kind = 0; kind < kLightKinds; ++kind) {
    const ExposureDecision& decision = exposure.light[static_cast<std::size_t>(kind)].decision;
    for (const ModelTest& test : decision.tests) {
      table.rows.push_back({{light_kind_name(kind)},
                            {model_text(test.model)},
                            {fmt::format("{:.1f}", test.largest_t)},
                            {name_of(set, test.picture)},
                            {fmt::format("{:.1f}", decision.t_limit)},
                            {test.rejected ? "contradicted" : "agrees"}});
    }
    if (decision.model == ExposureModel::kStations) {
      table.rows.push_back(
          {{light_kind_name(kind)}, {model_text(decision.model)}, {""}, {""}, {""}, {"taken"}});
    }
  }
  return table;
}

HtmlTable halves_table(const ExposureResult& exposure) {
  HtmlTable table{.caption = "Halves of the surfaces, measured separately (RMS over the frames)",
                  .header = {"light", "halves by", "disagree by", "expected by chance"}};
  for (int kind = 0; kind < kLightKinds; ++kind) {
    for (const HalvesComparison& halves : exposure.light[static_cast<std::size_t>(kind)].halves) {
      table.rows.push_back({{light_kind_name(kind)},
                            {halves.split},
                            {percent(halves.difference)},
                            {percent(halves.by_chance)}});
    }
  }
  return table;
}

HtmlTable frames_table(const CaptureSet& set, const ExposureResult& exposure) {
  HtmlTable table{.caption = "Brightness of every frame, relative to the mean of all",
                  .header = {"frame", "measured", "taken", "standard error", "significant",
                             "gain red", "green", "blue"}};
  const ExposureDecision& decision = exposure.light[0].decision;
  for (std::size_t i = 0; i < exposure.gains.size(); ++i) {
    if (!exposure.measured[i]) continue;
    const auto at = static_cast<Eigen::Index>(i);
    std::vector<HtmlCell> row{{set.frames[i].name},
                              {percent(decision.measured[at])},
                              {percent(decision.fitted[at])},
                              {percent(decision.error[at])},
                              {decision.correction[at] != 0.0 ? "yes" : "no"}};
    for (const double gain : exposure.gains[i]) {
      row.push_back({gain == 1.0 ? "1" : fmt::format("{:.4f}", gain)});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

LinePlot gain_plot(const CaptureSet& set, const ExposureResult& exposure) {
  LinePlot plot{.title = "Gain of every frame",
                .x_label = "position on the rail / m",
                .y_label = "mean gain / stops"};
  for (const CaptureLine& line : set.lines) {
    PlotSeries series{.name = line.id, .style = PlotStyle::kLineAndPoints};
    for (const int frame : line.frames) {
      const auto i = static_cast<std::size_t>(frame);
      if (!exposure.measured[i]) continue;
      series.points.push_back({set.rail_m(frame), mean_stops(exposure.gains[i])});
    }
    if (!series.points.empty()) plot.series.push_back(std::move(series));
  }
  return plot;
}

void add_evidence(const CaptureSet& set, const ExposureResult& exposure, HtmlPage* page) {
  page->add_paragraph(fmt::format(
      "How it was measured: {} small surfaces, each seen by two of {} pairs of frames, in {} of {} "
      "parts of the scene. Each is compared at its own distance, found by matching both ways, so "
      "that parallax does not enter; darkening towards the edges of the lenses is fitted as common "
      "to all frames. The standard errors come from the scatter between the parts of the scene, "
      "and from what halves of the surfaces disagree by beyond it. The pairs close {} loops, to "
      "{}. A difference counts if it would occur by chance in less than {:g} % of captures.",
      exposure.patches, exposure.links, exposure.scene_parts, kSceneParts, exposure.loops,
      percent(exposure.loop_error), 100.0 * kSignificance));
  page->add_table(models_table(set, exposure));
  page->add_table(halves_table(exposure));
  page->add_table(frames_table(set, exposure));
}

}  // namespace

std::string exposure_summary(const ExposureResult& exposure) {
  const std::size_t measured = measured_frames(exposure);
  if (measured == 0)
    return "no two frames show enough in common to compare exposures; none is corrected";
  const bool testable = !exposure.light[0].decision.tests.empty();
  if (!testable)
    return "too little of the scene is comparable to judge exposures; none is corrected";
  const std::size_t corrected = corrected_frames(exposure);
  if (corrected == 0) {
    return "no difference of exposure or colour exceeds its uncertainty; none is corrected";
  }
  double largest = 0.0;
  for (const LightGain& gain : exposure.gains) {
    largest = std::max(largest, std::abs(mean_stops(gain)));
  }
  return fmt::format(
      "exposures or colours differ; {} of {} frames are corrected, by at most {:.3f} stops",
      corrected, measured, largest);
}

ordered_json exposure_json(const CaptureSet& set, const ExposureResult& exposure) {
  ordered_json kinds = ordered_json::array();
  for (int kind = 0; kind < kLightKinds; ++kind) {
    const MeasuredLight& light = exposure.light[static_cast<std::size_t>(kind)];
    ordered_json tests = ordered_json::array(), halves = ordered_json::array();
    for (const ModelTest& test : light.decision.tests) {
      tests.push_back({{"model", exposure_model_name(test.model)},
                       {"largest_t", test.largest_t},
                       {"frame", name_of(set, test.picture)},
                       {"rejected", test.rejected}});
    }
    for (const HalvesComparison& split : light.halves) {
      halves.push_back({{"split", split.split},
                        {"difference", split.difference},
                        {"by_chance", split.by_chance}});
    }
    kinds.push_back({{"kind", light_kind_name(kind)},
                     {"model", exposure_model_name(light.decision.model)},
                     {"spread", light.spread},
                     {"t_limit", light.decision.t_limit},
                     {"t_limit_single", light.decision.t_limit_single},
                     {"tests", tests},
                     {"halves", halves}});
  }
  return {{"summary", exposure_summary(exposure)},
          {"corrected_frames", corrected_frames(exposure)},
          {"measured_frames", measured_frames(exposure)},
          {"links", exposure.links},
          {"patches", exposure.patches},
          {"scene_parts", exposure.scene_parts},
          {"loops", exposure.loops},
          {"loop_error", exposure.loop_error},
          {"significance", kSignificance},
          {"kinds", kinds}};
}

ordered_json frame_exposure_json(const ExposureResult& exposure, int frame) {
  ordered_json kinds;
  for (int kind = 0; kind < kLightKinds; ++kind) {
    const ExposureDecision& decision = exposure.light[static_cast<std::size_t>(kind)].decision;
    kinds[light_kind_name(kind)] = {{"measured", decision.measured[frame]},
                                    {"fitted", decision.fitted[frame]},
                                    {"error", decision.error[frame]},
                                    {"corrected", decision.correction[frame] != 0.0}};
  }
  return kinds;
}

void add_exposure(const CaptureSet& set, const ExposureResult& exposure, HtmlPage* page) {
  std::string summary = exposure_summary(exposure);
  summary.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(summary.front())));
  page->add_paragraph(summary + ".");
  if (corrected_frames(exposure) > 0) {
    page->add_figures({svg_figure(svg_from_plot(gain_plot(set, exposure)),
                                  "Mean over the colours; 0 stops: not corrected")});
  }
  if (!exposure.light[0].decision.tests.empty()) add_evidence(set, exposure, page);
}

}  // namespace raywalk::calibrate
