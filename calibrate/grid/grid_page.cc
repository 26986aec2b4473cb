#include "calibrate/grid/grid_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/grid/grid_drawing.h"
#include "calibrate/grid/line_summary.h"
#include "calibrate/grid/rail_model.h"
#include "core/report/html_page.h"
#include "core/report/svg_plot.h"

namespace raywalk::calibrate {
namespace {

std::string with_sigma(const Estimate& estimate, int decimals) {
  return fmt::format("{:.{}f} ± {:.{}f}", estimate.value, decimals, estimate.sigma, decimals);
}

void add_list(const std::string& heading, const std::vector<std::string>& texts, HtmlPage* page) {
  if (texts.empty()) return;
  page->add_section(heading);
  for (const std::string& text : texts) page->add_paragraph(text);
}

double worst(const GridResult& result, double Disagreement::*figure,
             Disagreement CrossingFigures::*when) {
  double largest = 0.0;
  for (const CrossingFigures& crossing : result.crossings) {
    largest = std::max(largest, crossing.*when.*figure);
  }
  return largest;
}

void add_summary(const GridResult& result, HtmlPage* page) {
  std::vector<HtmlFact> facts{{"trustworthy", result.trustworthy ? "yes" : "no"},
                              {"lines", fmt::format("{}", result.lines.size())},
                              {"crossings", fmt::format("{}", result.crossings.size())}};
  if (!result.crossings.empty()) {
    facts.push_back({"worst rotation, before",
                     fmt::format("{:.1f} px", worst(result, &Disagreement::rotation_px,
                                                    &CrossingFigures::before))});
    facts.push_back({"after", fmt::format("{:.2f} px", worst(result, &Disagreement::rotation_px,
                                                             &CrossingFigures::after))});
    facts.push_back({"worst position, before",
                     fmt::format("{:.1f} mm", worst(result, &Disagreement::position_mm,
                                                    &CrossingFigures::before))});
    facts.push_back({"after", fmt::format("{:.2f} mm", worst(result, &Disagreement::position_mm,
                                                             &CrossingFigures::after))});
  }
  if (result.method == GridMethod::kPoses) {
    facts.push_back({"scale", fmt::format("{:.5f}", result.scale)});
    facts.push_back({"common error of solved lines",
                     fmt::format("{:.2f} mm, {:.4f}°", result.solved_line_error_mm,
                                 result.solved_line_error_deg)});
  }
  page->add_facts(facts);
}

void add_crossings(const CaptureSet& set, const GridResult& result, HtmlPage* page) {
  if (result.crossings.empty()) return;
  page->add_section("Crossings");
  page->add_paragraph(
      "Displacement and rotation of the two lines' panoramas relative to each other, before and "
      "after, measured by matches held out of the estimate, with standard deviations from the "
      "matches' scatter. A remaining difference is significant only where it exceeds them. Pixels "
      "are those of a panorama 4096 wide. Epipolar: the median distance of a match from its "
      "epipolar line.");
  HtmlTable table{.header = {"crossing", "matches used", "held out", "displacement before, mm",
                             "after, mm", "rotation before, °", "after, °", "before, px",
                             "after, px", "epipolar before, px", "after, px"}};
  HtmlTable estimate{
      .caption = "Corrections by the estimate and their uncertainty",
      .header = {"crossing", "moved, mm", "rotated, °", "rotated, px", "σ, mm", "σ, °",
                 "halves differ, mm", "expected, mm", "halves differ, °", "expected, °"}};
  for (const CrossingFigures& crossing : result.crossings) {
    const std::string name = set.lines[static_cast<size_t>(crossing.along_x)].id + " × " +
                             set.lines[static_cast<size_t>(crossing.along_z)].id;
    const Disagreement& before = crossing.before;
    const Disagreement& after = crossing.after;
    table.rows.push_back({{name, !crossing.trustworthy},
                          {fmt::format("{}", crossing.matches)},
                          {fmt::format("{}", crossing.held_out_matches)},
                          {with_sigma({before.position_mm, before.position_sigma_mm}, 2)},
                          {with_sigma({after.position_mm, after.position_sigma_mm}, 2)},
                          {with_sigma({before.rotation_deg, before.rotation_sigma_deg}, 3)},
                          {with_sigma({after.rotation_deg, after.rotation_sigma_deg}, 3)},
                          {fmt::format("{:.2f}", before.rotation_px)},
                          {fmt::format("{:.2f}", after.rotation_px)},
                          {fmt::format("{:.2f}", before.median_px)},
                          {fmt::format("{:.2f}", after.median_px)}});
    estimate.rows.push_back({{name},
                             {fmt::format("{:.2f}", crossing.correction_mm)},
                             {fmt::format("{:.3f}", crossing.correction_deg)},
                             {fmt::format("{:.2f}", crossing.correction_px)},
                             {fmt::format("{:.2f}", crossing.sigma_mm)},
                             {fmt::format("{:.4f}", crossing.sigma_deg)},
                             {fmt::format("{:.2f}", crossing.split_half_mm)},
                             {fmt::format("{:.2f}", crossing.split_half_expected_mm)},
                             {fmt::format("{:.3f}", crossing.split_half_deg)},
                             {fmt::format("{:.3f}", crossing.split_half_expected_deg)}});
  }
  page->add_table(table);
  page->add_table(estimate);
}

void add_lines(const GridResult& result, HtmlPage* page) {
  page->add_section("Lines");
  page->add_paragraph(
      "The position of each line relative to the plan: its middle along and across the rail and in "
      "height, the direction of the rail, the attitude of the camera, and the stations' scatter "
      "about the rail (standard deviation per component). The common motion of all lines is "
      "unobservable; it is chosen so that the positions fit the plan best.");
  HtmlTable table{.header = {"line", "stations solved", "along, mm", "across, mm", "height, mm",
                             "heading, °", "tilt, °", "yaw, °", "pitch, °", "roll, °",
                             "scatter along, mm", "across, mm", "attitude, °"}};
  for (const LineFit& line : result.lines) {
    table.rows.push_back({{line.id, !line.connected && result.lines.size() > 1},
                          {fmt::format("{} of {}", line.solved_stations, line.stations)},
                          {with_sigma(line.along_mm, 2)},
                          {with_sigma(line.across_mm, 2)},
                          {with_sigma(line.height_mm, 2)},
                          {with_sigma(line.heading_deg, 3)},
                          {with_sigma(line.tilt_deg, 3)},
                          {with_sigma(line.yaw_deg, 3)},
                          {with_sigma(line.pitch_deg, 3)},
                          {with_sigma(line.roll_deg, 3)},
                          {fmt::format("{:.2f}", line.jitter_along_mm)},
                          {fmt::format("{:.2f}", line.jitter_mm)},
                          {fmt::format("{:.3f}", line.jitter_deg)}});
  }
  page->add_table(table);
}

void add_models(const GridResult& result, HtmlPage* page) {
  page->add_section("Models of the rails");
  page->add_paragraph(
      "The candidate model with the lowest Bayesian information criterion (BIC) is selected: a bow "
      "or a twist has to lower the residuals by more than its parameters would by fitting noise. "
      "Left out: the residual of stations left out of the fit (five-fold cross-validation). "
      "Whatever the model, the pose of a station with a solved pose is weighted between that pose "
      "and the rail by their variances.");
  HtmlTable table{.header = {"line", "model", "parameters", "residual", "left out", "BIC"}};
  for (const LineFit& line : result.lines) {
    const auto add = [&](const std::vector<RailModelScore>& models, const char* unit) {
      for (const RailModelScore& model : models) {
        table.rows.push_back({{line.id},
                              {model.name, model.kept},
                              {fmt::format("{}", model.parameters)},
                              {fmt::format("{:.3f} {}", model.residual, unit)},
                              {fmt::format("{:.3f} {}", model.left_out, unit)},
                              {fmt::format("{:.1f}", model.bic)}});
      }
    };
    add(line.position_models, "mm");
    add(line.rotation_models, "°");
  }
  page->add_table(table);
}

// The deviations of a line's stations from the rail, by component.
struct Deviations {
  LinePlot position{.x_label = "rail position, m", .y_label = "mm", .height_px = 300};
  LinePlot rotation{.x_label = "rail position, m", .y_label = "°", .height_px = 300};
};

Deviations deviations_of(const CaptureSet& set, const GridResult& result, const LineFit& line) {
  const RailFrame frame = rail_frame(set, line.line);
  const RailParameters parameters = rail_parameters(frame, line);
  const RailAxes<double> axes =
      rail_axes(frame.axis, parameters[RailParameter::kHeading], parameters[RailParameter::kTilt]);
  Deviations plots;
  for (const char* name : {"along", "across", "up"}) {
    plots.position.series.push_back({.name = name, .style = PlotStyle::kLineAndPoints});
  }
  for (const char* name : {"about x", "about y", "about z"}) {
    plots.rotation.series.push_back({.name = name, .style = PlotStyle::kLineAndPoints});
  }
  for (const int index : set.lines[static_cast<size_t>(line.line)].frames) {
    const FramePose& pose = *result.poses[static_cast<size_t>(index)];
    const double rail_m = set.rail_m(index);
    const Eigen::Vector3d off =
        1e3 * (pose.position_m - rail_position(frame, parameters.data(), rail_m));
    const Eigen::Matrix3d expected = matrix_of(rail_rotation(frame, parameters.data(), rail_m)) *
                                     planned_attitude(set.frames[static_cast<size_t>(index)]);
    const Eigen::Vector3d turn =
        degrees_from_radians(1.0) * vector_of(pose.world_from_camera * expected.transpose());
    const Eigen::Vector3d parts(off.dot(axes.direction), off.dot(axes.across), off.dot(axes.up));
    for (size_t i = 0; i < 3; ++i) {
      const auto component = static_cast<Eigen::Index>(i);
      plots.position.series[i].points.push_back({rail_m, parts[component]});
      plots.rotation.series[i].points.push_back({rail_m, turn[component]});
    }
  }
  return plots;
}

void add_deviations(const CaptureSet& set, const GridResult& result, HtmlPage* page) {
  page->add_section("Stations along the lines");
  page->add_paragraph(
      "The deviation of each station from the fitted rail. Random scatter is the rail's jitter "
      "from "
      "stop to stop; a smooth wave would be a bend that the model does not describe.");
  for (const LineFit& line : result.lines) {
    Deviations plots = deviations_of(set, result, line);
    plots.position.title = "Line " + line.id + ": position";
    plots.rotation.title = "Line " + line.id + ": attitude";
    page->add_figures(
        {svg_figure(svg_from_plot(plots.position), "Deviation of the position from the rail"),
         svg_figure(svg_from_plot(plots.rotation), "Deviation of the attitude from the rail")});
  }
}

}  // namespace

std::string grid_page(const CaptureSet& set, const GridResult& result) {
  HtmlPage page(
      "Grid of " + set.source.filename().string(),
      fmt::format("{} lines, {} stations, {}", set.lines.size(), set.frames.size(),
                  result.method == GridMethod::kPoses ? "from solved poses"
                                                      : "from matches at the crossings alone"));
  add_summary(result, &page);
  add_list("Warnings", result.warnings, &page);
  add_list("Notes", result.notes, &page);
  add_crossings(set, result, &page);
  page.add_section("Plan");
  page.add_figures({svg_figure(grid_drawing(set, result),
                               "Lines as planned (grey) and as estimated, with exaggerated "
                               "displacements")});
  add_lines(result, &page);
  add_models(result, &page);
  add_deviations(set, result, &page);
  return page.html();
}

}  // namespace raywalk::calibrate
