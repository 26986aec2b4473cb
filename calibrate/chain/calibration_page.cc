#include <fmt/format.h>

#include <algorithm>

#include "calibrate/chain/calibration_summary.h"
#include "calibrate/rectify/crossing_table.h"
#include "calibrate/rectify/rectify_report.h"
#include "core/files/atomic_output.h"
#include "core/report/html_page.h"
#include "core/report/markup.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

const char* purpose_of(CalibrationStep step) {
  switch (step) {
    case CalibrationStep::kLens:
      return "the lenses and the residuals of their fit";
    case CalibrationStep::kStitch:
      return "two fisheye pictures stitched to a panorama";
    case CalibrationStep::kMask:
      return "masks what moves with the camera";
    case CalibrationStep::kPoses:
      return "poses of the panoramas, solved from their features";
    case CalibrationStep::kGrid:
      return "lines of the rail, their models and crossings";
    case CalibrationStep::kRectify:
      return "frames in world axes, exposures";
  }
  return "";
}

// The maximum of a figure over the crossings.
template <typename Figure>
double worst(const std::vector<CrossingFigures>& crossings, const Figure& figure) {
  double largest = 0.0;
  for (const CrossingFigures& crossing : crossings) {
    largest = std::max(largest, figure(crossing));
  }
  return largest;
}

std::string before_after(double before, double after, int decimals, const std::string& unit) {
  return fixed_number(before, decimals) + " → " + fixed_number(after, decimals) + " " + unit;
}

void add_verdict(const CalibrationSummary& summary, const GridResult& grid, HtmlPage* page) {
  const auto& crossings = grid.crossings;
  std::vector<HtmlFact> facts{{"trustworthy", summary.trustworthy ? "yes" : "no"},
                              {"crossings", std::to_string(crossings.size())}};
  if (!crossings.empty()) {
    facts.push_back(
        {"largest rotation at a crossing, W = 4096",
         before_after(worst(crossings, [](const auto& c) { return c.before.rotation_px; }),
                      worst(crossings, [](const auto& c) { return c.after.rotation_px; }), 2,
                      "px")});
    facts.push_back(
        {"largest displacement at a crossing",
         before_after(worst(crossings, [](const auto& c) { return c.before.position_mm; }),
                      worst(crossings, [](const auto& c) { return c.after.position_mm; }), 2,
                      "mm")});
  }
  page->add_facts(facts);
  for (const std::string& warning : summary.warnings) page->add_paragraph("Warning: " + warning);
  for (const std::string& note : summary.notes) page->add_paragraph(note);
}

void add_lines(const GridResult& grid, HtmlPage* page) {
  page->add_section("The lines");
  const auto kept = [](const std::vector<RailModelScore>& models) -> std::string {
    for (const RailModelScore& model : models) {
      if (model.kept) return model.name;
    }
    return "–";
  };
  const auto text = [](const Estimate& estimate, int decimals) {
    return fixed_number(estimate.value, decimals) + " ± " + fixed_number(estimate.sigma, decimals);
  };
  HtmlTable table{
      .caption =
          "Corrections to the plan with one standard deviation, and the selected "
          "models of the rail (details in grid.html)",
      .header = {"line", "stations", "solved", "across / mm", "height / mm", "heading / deg",
                 "tilt / deg", "roll / deg", "positions", "attitudes"}};
  for (const LineFit& line : grid.lines) {
    table.rows.push_back({{line.id},
                          {std::to_string(line.stations)},
                          {std::to_string(line.solved_stations)},
                          {text(line.across_mm, 2)},
                          {text(line.height_mm, 2)},
                          {text(line.heading_deg, 3)},
                          {text(line.tilt_deg, 3)},
                          {text(line.roll_deg, 3)},
                          {kept(line.position_models)},
                          {kept(line.rotation_models)}});
  }
  page->add_table(table);
}

void add_steps(const Calibration& calibration, const CalibrationSummary& summary, HtmlPage* page) {
  page->add_section("The steps");
  std::vector<HtmlLink> links;
  for (const StepRun& run : summary.steps) {
    const std::string name = step_name(run.step);
    const std::string file = name + ".html";
    if (!fs::exists(calibration.out() / file)) continue;
    links.push_back({.file = file,
                     .text = name,
                     .note = fmt::format("{} ({:.1f} s{})", purpose_of(run.step), run.seconds,
                                         run.reused ? ", done earlier" : "")});
  }
  page->add_links(links);
}

void add_trade(const CalibrationSummary& summary, HtmlPage* page) {
  if (summary.trade.empty()) return;
  page->add_section("Accuracy and time of fewer keyframes");
  page->add_table(keyframe_table(summary.trade));
}

}  // namespace

void write_calibration_page(const Calibration& calibration, const CalibrationSummary& summary) {
  const CaptureSet& set = calibration.captured();
  const GridResult grid = calibration.grid();
  const RectifyResult rectified = calibration.rectified();
  HtmlPage page("Calibration of " + set.source.string(),
                fmt::format("{} stations on {} lines, {}", set.stations(), set.lines.size(),
                            grid.method == GridMethod::kPoses
                                ? "poses from COLMAP and the slider"
                                : "lines aligned at their crossings without solved poses"));
  add_verdict(summary, grid, &page);
  if (!grid.crossings.empty()) {
    page.add_section("At the crossings");
    page.add_table(crossing_table(set, grid.crossings));
  }
  add_lines(grid, &page);
  add_overlays(set, rectified, calibration.out(), &page);
  add_trade(summary, &page);
  add_steps(calibration, summary, &page);
  page.add_section("The next step");
  page.add_paragraph(pack_command(rectified, calibration.out()));
  write_file_atomically(calibration.out() / "index.html", page.html());
}

}  // namespace raywalk::calibrate
