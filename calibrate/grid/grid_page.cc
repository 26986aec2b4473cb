#include "calibrate/grid/grid_page.h"

#include "calibrate/grid/grid_sections.h"
#include "core/report/json_page.h"

namespace raywalk::calibrate {
namespace {

void add_corrections(JsonPage page) {
  page.table("crossings",
             {{"crossing", "{along_x} × {along_z}"},
              {"moved, mm", "{correction_mm:.2f}"},
              {"rotated, °", "{correction_deg:.3f}"},
              {"rotated, px", "{correction_px:.2f}"},
              {"halves differ, mm", "{split_half_mm:.2f}"},
              {"expected, mm", "{split_half_expected_mm:.2f}"},
              {"halves differ, °", "{split_half_deg:.3f}"},
              {"expected, °", "{split_half_expected_deg:.3f}"}},
             "Corrections by the estimate, and what two estimates from half of the stations each "
             "differ by");
}

void add_models(JsonPage page) {
  page.section("Models of the rails")
      .paragraph(
          "The candidate model with the lowest Bayesian information criterion (BIC) is selected: a "
          "bow or a twist has to lower the residuals by more than its parameters would by fitting "
          "noise. Left out: the residual of stations left out of the fit (five-fold "
          "cross-validation). Whatever the model, the pose of a station with a solved pose is "
          "weighted between that pose and the rail by their variances.");
  page.facts({{"scale of the solved poses", "{scale:.5f}"},
              {"common error of solved lines",
               "{solved_line_error_mm:.2f mm}, {solved_line_error_deg:.4f°}"}});
  const auto add_table = [&](std::string_view list, const std::string& unit,
                             std::string_view caption) {
    page.table(list,
               {{"line", "{^id}"},
                {"model", "{name}", "kept"},
                {"parameters", "{parameters}"},
                {"residual, " + unit, "{residual:.3f}"},
                {"left out, " + unit, "{left_out:.3f}"},
                {"BIC", "{bic:.1f}"}},
               caption);
  };
  add_table("lines.position_models", "mm", "Positions");
  add_table("lines.rotation_models", "°", "Attitudes");
}

void add_deviations(JsonPage page) {
  page.section("Stations along the lines")
      .paragraph(
          "The deviation of each station from the fitted rail. Random scatter is the rail's jitter "
          "from stop to stop; a smooth wave would be a bend that the model does not describe.");
  for (JsonPage& line : page.parts("deviations")) {
    const auto plot = [&](const std::string& what, const std::string& unit,
                          const std::vector<JsonSeries>& series) {
      return line.plot(
          {.title = "Line {line}: " + what, .x_label = "rail position, m", .y_label = unit}, series,
          "Deviation of the " + what + " from the rail");
    };
    line.figures({plot("position", "mm",
                       {{"stations", "along", "rail_m", "along_mm"},
                        {"stations", "across", "rail_m", "across_mm"},
                        {"stations", "up", "rail_m", "up_mm"}}),
                  plot("attitude", "°",
                       {{"stations", "about x", "rail_m", "about_x_deg"},
                        {"stations", "about y", "rail_m", "about_y_deg"},
                        {"stations", "about z", "rail_m", "about_z_deg"}})});
  }
}

}  // namespace

std::string grid_page(const nlohmann::ordered_json& document, const std::string& drawing) {
  JsonPage page(document, "Grid of {source}",
                "{lines:counted line}, {stations:counted station}, "
                "{method is poses:from solved poses|from matches at the crossings alone}");
  add_verdict(page);
  add_crossings("crossings", page);
  add_corrections(page);
  page.section("Plan").figures({svg_figure(
      drawing, "Lines as planned (grey) and as estimated, with exaggerated displacements")});
  add_lines(page);
  add_models(page.when("method is poses"));
  add_deviations(page);
  return page.html();
}

}  // namespace raywalk::calibrate
