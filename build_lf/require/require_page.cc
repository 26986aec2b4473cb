#include "build_lf/require/require_page.h"

#include <nlohmann/json.hpp>

#include "core/report/json_page.h"

namespace raywalk::build_lf {
namespace {

void add_scene(const RequirementFigures& figures, JsonPage page) {
  page.section("Distances of the scene")
      .paragraph(
          "Distances from the stations, weighted by solid angle and confidence: 1 % are nearer "
          "than {distance.near_m:.2f m|sky}, half nearer than {distance.median_m:.2f m|sky}, 99 % "
          "nearer than {distance.far_m:.2f m|sky}. Sky covers {distance.sky_share:.1%} of the "
          "directions; {distance.known_share:.1%} of them are known.");
  page.when("distance.omega_error_per_m")
      .paragraph(
          "Where two maps see the same surface, 95 % of the pixels agree on its inverse distance "
          "within {distance.omega_error_per_m:.5f} per metre: "
          "{distance.error_at_median_m:length|any} at {distance.median_m:.2f m|sky}.");
  page.figures({figures.directions}).figures(figures.around);
}

void add_layers(const RequirementFigures& figures, JsonPage page) {
  page.section("Depth layers")
      .paragraph(
          "A view a distance d_p from the line moves each ray's latitude by up to d_p times the "
          "inverse distance of its source. With layers equally spaced in inverse distance, from "
          "{layers.omega_min_per_m:.3f} to {layers.omega_max_per_m:.3f} per metre, an error of "
          "half a layer remains. These counts keep it within {tolerance_px:g px} at "
          "{storage.panorama_width_px} px, except for rays that graze a surface at more than 80 "
          "degrees.")
      .figures({figures.layers})
      .table("layers.by_d_p", {{"d_p", "{d_p_m:.3f m}"}, {"layers", "{layers}"}},
             "Layers by distance from the line");
}

JsonTable spacing_table() {
  const auto row = [](const char* known, const std::string& needed, const std::string& list = "") {
    const std::string captured = "/spacing.captured_median_m";
    return JsonRows{.list = list,
                    .cells = {{known},
                              {"{" + needed + ":length|any}", "!" + needed + " < " + captured},
                              {"{" + captured + ":length}"}}};
  };
  return {.caption = "Spacing needed, by knowledge of the distances",
          .header = {"known", "spacing needed", "captured spacing"},
          .rows = {row("nothing (blended in place)", "spacing.needed_without_depth_m"),
                   row("{layers:counted layer}", "needed_m", "spacing.needed_with_layers"),
                   row("distances, from their error alone", "spacing.needed_by_error_m"),
                   row("distances, by re-created stations", "spacing.measured_up_to_m")}};
}

HtmlFigure held_out_plot(const nlohmann::ordered_json& document, const JsonPage& page) {
  const double needed_m = document["spacing"]["needed_with_distances_m"];
  const std::string list = "spacing.held_out", step = "step_m as cm";
  return page.plot({.x_label = "step between the stations kept / cm",
                    .y_label = "PSNR / dB",
                    .references = {{100.0 * needed_m, "needed"}}},
                   {{list, "with distances", step, "psnr_with_distances_db"},
                    {list, "without depth", step, "psnr_without_depth_db"},
                    {list, "{/tolerance_px:g px} off", step, "psnr_of_tolerance_db"}},
                   "Measured: PSNR of stations left out and re-created; the captured station "
                   "displaced by the tolerance for comparison.");
}

void add_spacing(const RequirementFigures& figures, const HtmlFigure& held_out, JsonPage page) {
  page.section("Spacing of the stations")
      .paragraph(
          "Plenoptic sampling along a rail: a source at inverse distance w appears in two "
          "stations, a step s apart, in directions s w apart. A blend without correction shows it "
          "twice; corrected by an assumed distance, the copies are apart by the error of that "
          "distance. One layer is Chai's optimal single depth; his critical sampling is a "
          "tolerance of 1 px about it. Here it is {tolerance_px:g px}, {tolerance_deg:.4g} "
          "degrees.")
      .figures({figures.ghosts, held_out})
      .table(spacing_table())
      .table("spacing.held_out",
             {{"every", "{stride}"},
              {"step", "{step_m:length}"},
              {"views", "{views}"},
              {"with distances", "{psnr_with_distances_db:.1f dB}",
               "psnr_with_distances_db >= psnr_of_tolerance_db"},
              {"without depth", "{psnr_without_depth_db:.1f dB}"},
              {"tolerance", "{psnr_of_tolerance_db:.1f dB}"},
              {"hidden from both", "{hidden_share:.1%}"}},
             "The middle station of each gap, re-created from its two neighbours")
      .paragraph(
          "With distances {spacing.stations_needed_with_distances} of {spacing.stations} stations "
          "suffice, including those at corners and ends. Without depth they may be at most "
          "{spacing.needed_without_depth_m:length|any distance} apart, and the capture is "
          "{spacing.captured_max_m > spacing.needed_without_depth_m:not dense enough|dense "
          "enough}. The rule for distances ignores occlusion, reflections and resampling, which "
          "the re-created stations measure: the smaller of the two spacings is used.");
}

void add_connection(const RequirementFigures& figures, JsonPage page) {
  page.section("Connection between lines");
  page.when("!connection.k_deg").paragraph("The room has no cell, so no lines connect.");
  JsonPage cells = page.when("connection.k_deg");
  cells.paragraph(
      "--k auto takes {connection.k_deg:g} degrees for hlf-vd views: {connection.k_source}.");
  cells.when("!connection.measured")
      .paragraph(
          "raywalk-render connect-error {room} --generation initial,hlf-vd,two-sided measures "
          "E_connect; the model E_t is shown for comparison and chooses nothing.");
  cells.figures(figures.connection)
      .table({.caption = "k with the least error",
              .header = {"by", "k", "E_connect"},
              .rows = {
                  {.cells = {{"model E_t"}, {"{connection.model_k_deg:g}"}, {"–"}}},
                  {.list = "connection.measured",
                   .cells = {
                       {"measured, {generation}"}, {"{k_deg:g}", "k_deg"}, {"{e_connect:.2f}"}}}}});
}

JsonTable bytes_table() {
  const auto row = [](const char* what, const std::string& bytes, const std::string& original) {
    return JsonRows{.cells = {{what},
                              {"{" + bytes + " as MB:.1f MB}"},
                              {"{" + bytes + " / " + original + ":.1%}"}}};
  };
  return {
      .caption = "Bytes",
      .header = {"what", "bytes", "of the original"},
      .rows = {row("rays as captured", "ray_bytes", "ray_bytes"),
               row("rays of the stations needed", "ray_bytes_thinned", "ray_bytes"),
               row("... at the width worth storing", "ray_bytes_worth", "ray_bytes"),
               row("distances, {distance_width_px} px wide", "distance_bytes", "distance_bytes"),
               row("distances, {needed_distance_width_px} px wide, {omega_bits} bits",
                   "distance_bytes_needed", "distance_bytes")}};
}

void add_storage(JsonPage storage) {
  storage.section("Storage")
      .paragraph(
          "Width: with the error of the distances, at half a cell ({reach_m:.2f m}) and half a "
          "step, the residual parallax equals {/tolerance_px:g px} of a panorama of "
          "{worth_width_px:.0f px|any width}; a wider one stores detail that views "
          "displace by more. Distances: maps {needed_distance_width_px} px wide keep "
          "{share_within_tolerance:.1%} of the directions within the tolerance at this reach, "
          "which needs {omega_steps} steps of inverse distance, {omega_bits} bits.")
      .table(bytes_table());
}

void add_thinned(JsonPage thinned) {
  thinned.section("The thinned room")
      .facts({{"room", "{room}"},
              {"stations", "{stations}"},
              {"distance maps", "{distance_maps}"},
              {"bytes", "{bytes as MB:.1f MB}"},
              {"dropped ones re-created", "{views}"},
              {"mean PSNR", "{psnr_db:.1f dB}"},
              {"worst PSNR", "{worst_psnr_db:.1f dB}"}});
}

}  // namespace

std::string require_page(const nlohmann::ordered_json& document,
                         const RequirementFigures& figures) {
  JsonPage page(document, "What {room} requires",
                "{lines:counted line}, {spacing.stations} stations of {storage.panorama_width_px} "
                "x {storage.panorama_height_px} px, for a tolerance of {tolerance_px:g px}");
  page.facts({{"surfaces", "{distance.near_m:.2f m|sky} to {distance.far_m:.2f m|sky}"},
              {"distances", "{distances}"},
              {"layers in the middle of a cell", "{layers.at_reach}"},
              {"spacing, without depth", "{spacing.needed_without_depth_m:length|any}"},
              {"spacing, with distances", "{spacing.needed_with_distances_m:length}"},
              {"captured", "{spacing.captured_median_m:length}"},
              {"stations needed", "{spacing.stations_needed_with_distances} of {spacing.stations}"},
              {"k", "{connection.k_deg:g degrees|no cell}"},
              {"width worth storing", "{storage.worth_width_px:.0f px|any}"}});
  add_scene(figures, page);
  add_layers(figures, page);
  add_spacing(figures, held_out_plot(document, page.when("spacing.held_out")), page);
  add_connection(figures, page);
  add_storage(page.within("storage"));
  add_thinned(page.within("thinned"));
  return page.html();
}

}  // namespace raywalk::build_lf
