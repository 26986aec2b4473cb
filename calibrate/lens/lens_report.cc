#include "calibrate/lens/lens_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/lens/lens_values.h"
#include "calibrate/lens/residual_picture.h"
#include "core/report/html_page.h"
#include "core/report/markup.h"
#include "core/report/svg_plot.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

const char* lens_name(bool back) { return back ? "back" : "front"; }

bool from_board(const LensFit& fit) { return fit.method == "charuco"; }

ordered_json json_of(const LensValue& value) {
  return {{"start", value.start},
          {"fitted", value.fitted},
          {"sigma", value.sigma > 0.0 ? ordered_json(value.sigma) : ordered_json(nullptr)}};
}

ordered_json json_of(const std::vector<LensValue>& values) {
  ordered_json json = ordered_json::object();
  for (const LensValue& value : values) json[value.key] = json_of(value);
  return json;
}

ordered_json json_of(const std::vector<LensValue>& values, const LensUncertainty& sigma) {
  ordered_json json = json_of(values);
  json["imaging_sigma_px"] = {{"middle", sigma.middle_px}, {"rim", sigma.rim_px}};
  return json;
}

HtmlTable table_of(const std::string& caption, const std::vector<LensValue>& values) {
  HtmlTable table{.caption = caption,
                  .header = {"", "unit", "start", "fitted", "standard deviation"}};
  for (const LensValue& value : values) {
    table.rows.push_back(
        {{value.name},
         {value.unit},
         {fixed_number(value.start, value.decimals)},
         {fixed_number(value.fitted, value.decimals)},
         {value.sigma > 0.0 ? fixed_number(value.sigma, value.decimals + 1) : "not fitted"}});
  }
  return table;
}

void add_headline(const LensFit& fit, HtmlPage* page) {
  page->add_facts(
      {{"root mean square residual", fmt::format("{:.3f} px", fit.residual_px)},
       {"largest standard deviation of an image position",
        fmt::format("{:.3f} px", fit.sigma.worst_px())},
       {from_board(fit) ? "board corners" : "features followed", std::to_string(fit.points)},
       {"seen by both lenses", std::to_string(fit.overlap_points)}});
  for (const std::string& warning : fit.warnings) page->add_paragraph("Warning: " + warning + ".");
  if (fit.trustworthy()) page->add_paragraph("No warnings.");
}

HtmlTable counts_table(const LensFit& fit) {
  const auto row = [](const std::string& name, int count) {
    return std::vector<HtmlCell>{{name}, {std::to_string(count)}};
  };
  HtmlTable table{.caption = "Data of the fit", .header = {"", "number"}};
  table.rows = {
      row(from_board(fit) ? "pictures that show the board" : "stations", fit.pictures),
      row(from_board(fit) ? "corners, once per picture" : "features of the room", fit.points),
      row("seen by both lenses", fit.overlap_points), row("image points", fit.observations),
      row("image points dropped as outliers", fit.dropped_observations)};
  if (!from_board(fit)) {
    table.rows.push_back(row("features dropped: they move with the camera", fit.dropped_still));
  }
  return table;
}

LinePlot ring_plot(const std::vector<ResidualRing>& rings) {
  LinePlot plot{.title = "Residuals over the angle from the axis",
                .x_label = "angle from the axis / deg",
                .y_label = "residual / px"};
  for (const bool back : {false, true}) {
    PlotSeries rms{
        fmt::format("{}: root mean square", lens_name(back)), {}, PlotStyle::kLineAndPoints};
    PlotSeries radial{
        fmt::format("{}: mean outwards", lens_name(back)), {}, PlotStyle::kLineAndPoints};
    for (const ResidualRing& ring : rings) {
      if (ring.back != back) continue;
      const double angle_deg = degrees_from_radians(ring.off_axis_rad);
      rms.points.push_back({angle_deg, ring.rms_px});
      radial.points.push_back({angle_deg, ring.radial_px});
    }
    plot.series.push_back(std::move(rms));
    plot.series.push_back(std::move(radial));
  }
  return plot;
}

}  // namespace

std::string lens_page(const LensFit& fit) {
  HtmlPage page("Lenses of the camera", from_board(fit) ? "from pictures of a ChArUco board"
                                                        : "from features tracked along the rail");
  add_headline(fit, &page);
  page.add_section("Residuals");
  page.add_paragraph(
      "Residuals of the image points: observed minus fitted. Arrows of random directions are "
      "noise; "
      "arrows that agree with their neighbours show an error of the lens model.");
  page.add_figures(
      {svg_figure(residual_picture(fit, false), "Front lens"),
       svg_figure(residual_picture(fit, true), "Back lens"),
       svg_figure(svg_from_plot(ring_plot(residual_rings(fit))),
                  "Rings of five degrees. A mean outwards other than 0 is an error of the radial "
                  "model")});
  page.add_table(counts_table(fit));
  page.add_section("Values");
  page.add_paragraph(fmt::format(
      "A direction at the angle t from a lens's axis is imaged at focal length (t + k1 t^3 + k2 "
      "t^5 + k3 t^7 + k4 t^9) from the centre, in pictures of {} x {} pixels. The coefficients "
      "are correlated, so their standard deviations look large. The standard deviation of a "
      "direction's image position is {:.3f} px half way to the rim and {:.3f} px at the rim for "
      "the front lens, {:.3f} and {:.3f} px for the back lens.",
      fit.camera.picture.width, fit.camera.picture.height, fit.sigma.front.middle_px,
      fit.sigma.front.rim_px, fit.sigma.back.middle_px, fit.sigma.back.rim_px));
  page.add_table(table_of("Front lens", front_values(fit)));
  page.add_table(
      table_of("Back lens, with its attitude relative to the front lens", back_values(fit)));
  page.add_table(
      table_of("Position of the back lens relative to the front lens", baseline_values(fit)));
  return page.html();
}

std::string lens_json(const LensFit& fit) {
  ordered_json json{{"format", "raywalk-lens"},
                    {"format_version", 1},
                    {"method", fit.method},
                    {"trustworthy", fit.trustworthy()},
                    {"warnings", fit.warnings},
                    {"residual_px", fit.residual_px},
                    {"pictures", fit.pictures},
                    {"points", fit.points},
                    {"overlap_points", fit.overlap_points},
                    {"observations", fit.observations},
                    {"dropped_observations", fit.dropped_observations},
                    {"dropped_still", fit.dropped_still},
                    {"back_pose_fitted", fit.back_pose_fitted}};
  json["picture"] = {{"width_px", fit.camera.picture.width},
                     {"height_px", fit.camera.picture.height},
                     {"two_files", fit.camera.two_files}};
  json["front"] = json_of(front_values(fit), fit.sigma.front);
  json["back"] = json_of(back_values(fit), fit.sigma.back);
  json["baseline_mm"] = json_of(baseline_values(fit));
  json["residuals_over_angle"] = ordered_json::array();
  for (const ResidualRing& ring : residual_rings(fit)) {
    json["residuals_over_angle"].push_back(
        {{"lens", lens_name(ring.back)},
         {"off_axis_deg", degrees_from_radians(ring.off_axis_rad)},
         {"count", ring.count},
         {"rms_px", ring.rms_px},
         {"radial_px", ring.radial_px}});
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace raywalk::calibrate
