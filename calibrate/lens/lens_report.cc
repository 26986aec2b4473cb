#include "calibrate/lens/lens_report.h"

#include <nlohmann/json.hpp>

#include "calibrate/lens/lens_values.h"
#include "calibrate/lens/residual_picture.h"
#include "core/report/json_page.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

ordered_json values_json(const std::vector<LensValue>& values) {
  ordered_json json = ordered_json::object();
  for (const LensValue& value : values) {
    json[value.key] = {{"start", value.start}, {"fitted", value.fitted}, {"sigma", nullptr}};
    if (value.sigma > 0.0) json[value.key]["sigma"] = value.sigma;
  }
  return json;
}

ordered_json lens_values_json(const std::vector<LensValue>& values, const LensUncertainty& sigma) {
  ordered_json json = values_json(values);
  json["imaging_sigma_px"] = {{"middle", sigma.middle_px}, {"rim", sigma.rim_px}};
  return json;
}

ordered_json rings_json(const std::vector<ResidualRing>& rings) {
  ordered_json json = ordered_json::array();
  for (const ResidualRing& ring : rings) {
    json.push_back({{"lens", ring.back ? "back" : "front"},
                    {"off_axis_deg", degrees_from_radians(ring.off_axis_rad)},
                    {"count", ring.count},
                    {"rms_px", ring.rms_px},
                    {"radial_px", ring.radial_px}});
  }
  return json;
}

void add_residuals(std::vector<HtmlFigure> figures, JsonPage page) {
  const LinePlot axes{.title = "Residuals over the angle from the axis",
                      .x_label = "angle from the axis / deg",
                      .y_label = "residual / px"};
  const std::string rings = "residuals_over_angle";
  figures.push_back(
      page.plot(axes,
                {{rings, "{lens}: root mean square", "off_axis_deg", "rms_px"},
                 {rings, "{lens}: mean outwards", "off_axis_deg", "radial_px"}},
                "Rings of five degrees. A mean outwards other than 0 is an error of the radial "
                "model"));
  page.section("Residuals")
      .paragraph(
          "Residuals of the image points: observed minus fitted. Arrows of random directions are "
          "noise; arrows that agree with their neighbours show an error of the lens model.")
      .figures(std::move(figures))
      .facts({{"{method is charuco:pictures that show the board|stations}", "{pictures}"},
              {"image points", "{observations}"},
              {"image points dropped as outliers", "{dropped_observations}"},
              {"features dropped: they move with the camera", "{dropped_still}",
               "!method is charuco"}});
}

// A value in its part of the document.
JsonRows row_of(const std::string& key, const std::string& name, int decimals) {
  const auto number = [&](const char* figure, int digits, const char* otherwise) {
    return "{" + key + "." + figure + ":." + std::to_string(digits) + "f" + otherwise + "}";
  };
  return {.cells = {{name},
                    {number("start", decimals, "")},
                    {number("fitted", decimals, "")},
                    {number("sigma", decimals + 1, "|not fitted")}}};
}

JsonTable table_of(const std::string& caption, const std::vector<JsonRows>& rows) {
  return {caption, {"", "start", "fitted", "standard deviation"}, rows};
}

void add_values(JsonPage page) {
  std::vector<JsonRows> rows{row_of("centre_u_px", "centre, from the left / px", 2),
                             row_of("centre_v_px", "centre, from the top / px", 2),
                             row_of("focal_px", "focal length / px", 2),
                             row_of("k1", "k1", 5),
                             row_of("k2", "k2", 5),
                             row_of("k3", "k3", 5),
                             row_of("k4", "k4", 5),
                             row_of("largest_angle_deg", "half field of view / deg", 2)};
  page.section("Values").paragraph(
      "A direction at the angle t from a lens's axis is imaged at focal length (t + k1 t^3 + k2 "
      "t^5 + k3 t^7 + k4 t^9) from the centre, in pictures of {picture.width_px} x "
      "{picture.height_px} pixels. The coefficients are correlated, so their standard deviations "
      "look large. The standard deviation of a direction's image position is "
      "{front.imaging_sigma_px.middle:.3f px} half way to the rim and "
      "{front.imaging_sigma_px.rim:.3f px} at the rim for the front lens, "
      "{back.imaging_sigma_px.middle:.3f} and {back.imaging_sigma_px.rim:.3f px} for the back "
      "lens.");
  page.within("front").table(table_of("Front lens", rows));
  rows.push_back(row_of("yaw_deg", "yaw / deg", 3));
  rows.push_back(row_of("pitch_deg", "pitch / deg", 3));
  rows.push_back(row_of("roll_deg", "roll / deg", 3));
  page.within("back").table(
      table_of("Back lens, with its attitude relative to the front lens", rows));
  page.within("baseline_mm")
      .table(table_of("Position of the back lens relative to the front lens",
                      {row_of("x", "to the right / mm", 2), row_of("y", "upwards / mm", 2),
                       row_of("z", "forwards / mm", 2)}));
}

}  // namespace

ordered_json lens_document(const LensFit& fit) {
  return {{"format", "raywalk-lens"},
          {"format_version", 1},
          {"method", fit.method},
          {"trustworthy", fit.trustworthy()},
          {"warnings", fit.warnings},
          {"residual_px", fit.residual_px},
          {"worst_imaging_sigma_px", fit.sigma.worst_px()},
          {"pictures", fit.pictures},
          {"points", fit.points},
          {"overlap_points", fit.overlap_points},
          {"observations", fit.observations},
          {"dropped_observations", fit.dropped_observations},
          {"dropped_still", fit.dropped_still},
          {"back_pose_fitted", fit.back_pose_fitted},
          {"picture",
           {{"width_px", fit.camera.picture.width},
            {"height_px", fit.camera.picture.height},
            {"two_files", fit.camera.two_files}}},
          {"front", lens_values_json(front_values(fit), fit.sigma.front)},
          {"back", lens_values_json(back_values(fit), fit.sigma.back)},
          {"baseline_mm", values_json(baseline_values(fit))},
          {"residuals_over_angle", rings_json(residual_rings(fit))}};
}

std::vector<HtmlFigure> residual_figures(const LensFit& fit) {
  return {svg_figure(residual_picture(fit, false), "Front lens"),
          svg_figure(residual_picture(fit, true), "Back lens")};
}

std::string lens_page(const ordered_json& document, std::vector<HtmlFigure> residuals) {
  JsonPage page(document, "Lenses of the camera",
                "{method is charuco:from pictures of a ChArUco board|from features tracked along "
                "the rail}");
  page.facts(
      {{"root mean square residual", "{residual_px:.3f px}"},
       {"largest standard deviation of an image position", "{worst_imaging_sigma_px:.3f px}"},
       {"{method is charuco:board corners, once per picture|features followed}", "{points}"},
       {"seen by both lenses", "{overlap_points}"}});
  page.warnings("warnings");
  page.when("trustworthy").paragraph("No warnings.");
  add_residuals(std::move(residuals), page);
  add_values(page);
  return page.html();
}

}  // namespace raywalk::calibrate
