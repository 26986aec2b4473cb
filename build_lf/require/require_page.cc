#include "build_lf/require/require_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "build_lf/require/floor_plan.h"
#include "build_lf/require/requirement_plots.h"
#include "build_lf/require/scene_plots.h"
#include "core/report/html_page.h"
#include "core/report/markup.h"
#include "core/room/choose_k.h"

namespace raywalk::build_lf {
namespace {

std::string metres(double value) {
  return std::isfinite(value) ? fixed_number(value, 2) + " m" : "sky";
}
std::string spacing(double value_m) {
  if (!std::isfinite(value_m)) return "any";
  return value_m < 0.01 ? fixed_number(1000.0 * value_m, 1) + " mm"
                        : fixed_number(100.0 * value_m, 1) + " cm";
}
std::string megabytes(std::uint64_t bytes) {
  return fixed_number(static_cast<double>(bytes) * 1e-6, 1) + " MB";
}
std::string percent(double share) { return fixed_number(100.0 * share, 1) + " %"; }
std::string pixels(double width) {
  return std::isfinite(width) ? fixed_number(width, 0) + " px" : "any";
}
std::string share_of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? "-" : percent(static_cast<double>(part) / static_cast<double>(whole));
}

int layers_at_reach(const RoomRequirements& r) {
  int layers = 1;
  for (const LayersAtDistance& each : r.layers.by_d_p) {
    if (each.d_p_m <= r.storage.reach_m) layers = each.layers;
  }
  return layers;
}

ChosenK chosen_k(const Room& room) { return choose_k(room, "hlf-vd"); }

std::string recommended_k(const Room& room) {
  if (room.grid().cells.empty()) return "no cell";
  return fmt::format("{:g} degrees", chosen_k(room).k_deg);
}

void add_facts(const Room& room, const RoomRequirements& r, HtmlPage* page) {
  page->add_facts(
      {{"surfaces", metres(r.distance.near_m) + " to " + metres(r.distance.far_m)},
       {"distances", r.distances},
       {"layers in the middle of a cell", std::to_string(layers_at_reach(r))},
       {"spacing, without depth", spacing(r.spacing.needed_without_depth_m)},
       {"spacing, with distances", spacing(r.spacing.needed_with_distances_m)},
       {"captured", spacing(r.spacing.captured_median_m)},
       {"stations needed",
        fmt::format("{} of {}", r.spacing.stations_needed_with_distances, r.spacing.stations)},
       {"k", recommended_k(room)},
       {"width worth storing", pixels(r.storage.worth_width_px)}});
}

void add_scene(const Room& room, const RoomRequirements& r, const KeptStations& needed,
               HtmlPage* page) {
  page->add_section("Distances of the scene");
  page->add_paragraph(fmt::format(
      "Distances from the stations, weighted by solid angle and confidence: 1 % are nearer than "
      "{}, half nearer than {}, 99 % nearer than {}. Sky covers {} of the directions; {} of them "
      "are known.",
      metres(r.distance.near_m), metres(r.distance.median_m), metres(r.distance.far_m),
      percent(r.distance.sky_share), percent(r.distance.known_share)));
  if (r.distance.omega_error_per_m) {
    page->add_paragraph(fmt::format(
        "Where two maps see the same surface, 95 % of the pixels agree on its inverse distance "
        "within {} per metre: {} at {}.",
        fixed_number(*r.distance.omega_error_per_m, 5),
        spacing(*r.distance.omega_error_per_m * r.distance.median_m * r.distance.median_m),
        metres(r.distance.median_m)));
  }
  page->add_figures(
      {svg_figure(
           direction_map_svg(r.distance),
           "Nearest surface (1 % quantile) per field of 15 x 15 degrees, in metres, laid out "
           "as a panorama: longitude across, latitude up."),
       svg_figure(floor_plan_svg(room, needed),
                  "From above: surfaces near eye level (grey), stations that are needed with "
                  "distances (filled) and those that could be left out (rings)."),
       svg_figure(horizon_svg(r.distance),
                  "Around the horizon, within 15 degrees: median (line), and from the nearest 1 % "
                  "to the farthest (band)."),
       svg_figure(layers_plot(r), "Depth layers over the distance from the line; see below.")});
}

HtmlTable layers_table(const RoomRequirements& r) {
  HtmlTable table{
      .caption = "Layers by distance from the line", .header = {"d_p", "layers"}, .rows = {}};
  for (const LayersAtDistance& each : r.layers.by_d_p) {
    table.rows.push_back({{fixed_number(each.d_p_m, 3) + " m"}, {std::to_string(each.layers)}});
  }
  return table;
}

void add_layers(const RoomRequirements& r, HtmlPage* page) {
  page->add_section("Depth layers");
  page->add_paragraph(fmt::format(
      "A view a distance d_p from the line moves each ray's latitude by up to d_p times the "
      "inverse distance of its source. With layers equally spaced in inverse distance, from {} to "
      "{} per metre, an error of half a layer remains. These counts keep it within {:g} px at {} "
      "px, except for rays that graze a surface at more than 80 degrees.",
      fixed_number(r.layers.omega_min_per_m, 3), fixed_number(r.layers.omega_max_per_m, 3),
      r.tolerance_px, r.storage.panorama_width_px));
  page->add_table(layers_table(r));
}

HtmlTable spacing_table(const RoomRequirements& r) {
  HtmlTable table{.caption = "Spacing needed, by knowledge of the distances",
                  .header = {"known", "spacing needed", "captured spacing"},
                  .rows = {}};
  const auto add = [&](const std::string& known, double needed_m) {
    table.rows.push_back({{known},
                          {spacing(needed_m), needed_m >= r.spacing.captured_median_m},
                          {spacing(r.spacing.captured_median_m)}});
  };
  add("nothing (blended in place)", r.spacing.needed_without_depth_m);
  for (const SpacingWithLayers& each : r.spacing.needed_with_layers) {
    add(each.layers == 1 ? "one depth (Chai's optimum)" : fmt::format("{} layers", each.layers),
        each.needed_m);
  }
  add("distances, from their error alone", r.spacing.needed_by_error_m);
  add("distances, by re-created stations", r.spacing.measured_up_to_m);
  return table;
}

HtmlTable held_out_table(const RoomRequirements& r) {
  HtmlTable table{.caption = "The middle station of each gap, re-created from its two neighbours",
                  .header = {"every", "step", "views", "with distances", "without depth",
                             "tolerance", "hidden from both"},
                  .rows = {}};
  for (const HeldOutFacts& each : r.spacing.held_out) {
    const bool within = each.psnr_with_distances_db >= each.psnr_of_tolerance_db;
    table.rows.push_back({{std::to_string(each.stride)},
                          {spacing(each.step_m)},
                          {std::to_string(each.views)},
                          {fixed_number(each.psnr_with_distances_db, 1) + " dB", within},
                          {fixed_number(each.psnr_without_depth_db, 1) + " dB"},
                          {fixed_number(each.psnr_of_tolerance_db, 1) + " dB"},
                          {percent(each.hidden_share)}});
  }
  return table;
}

void add_spacing(const RoomRequirements& r, HtmlPage* page) {
  page->add_section("Spacing of the stations");
  page->add_paragraph(fmt::format(
      "Plenoptic sampling along a rail: a source at inverse distance w appears in two stations, a "
      "step s apart, in directions s w apart. A blend without correction shows it twice; corrected "
      "by an assumed distance, the copies are apart by the error of that distance. Chai's critical "
      "sampling is a tolerance of 1 px about the optimal single depth; here it is {:g} px, {} "
      "degrees.",
      r.tolerance_px, plain_number(360.0 * r.tolerance_px / r.storage.panorama_width_px, 4)));
  page->add_figures(
      {svg_figure(ghost_plot(r), "Distance between the two copies of the nearest source."),
       svg_figure(held_out_plot(r),
                  "Measured: PSNR of stations left out and re-created; the captured station "
                  "displaced by the tolerance for comparison.")});
  page->add_table(spacing_table(r));
  page->add_table(held_out_table(r));
  page->add_paragraph(fmt::format(
      "With distances {} of {} stations suffice, including those at corners and ends. Without "
      "depth they may be at most {} apart, and the capture is {}. The rule for distances ignores "
      "occlusion, reflections and resampling, which the re-created stations measure: the smaller "
      "of the two spacings is used.",
      r.spacing.stations_needed_with_distances, r.spacing.stations,
      spacing(r.spacing.needed_without_depth_m),
      r.spacing.captured_max_m <= r.spacing.needed_without_depth_m ? "dense enough"
                                                                   : "not dense enough"));
}

void add_connection(const Room& room, const RoomRequirements& r, HtmlPage* page) {
  page->add_section("Connection between lines");
  if (!r.connection.model_k_deg) {
    page->add_paragraph("The room has no cell, so no lines connect.");
    return;
  }
  std::vector<HtmlFigure> figures{
      svg_figure(model_plot(room, r), "The model E_t over the room's distances.")};
  const ChosenK chosen = chosen_k(room);
  page->add_paragraph(fmt::format("--k auto takes {:g} degrees for hlf-vd views: {}.", chosen.k_deg,
                                  chosen.source));
  if (r.connection.measured.empty()) {
    page->add_paragraph(fmt::format(
        "raywalk-render connect-error {} --generation initial,hlf-vd,two-sided measures E_connect; "
        "the model E_t is shown for comparison and chooses nothing.",
        room.directory().string()));
  } else {
    figures.push_back(svg_figure(measured_connection_plot(room),
                                 "Measured E_connect, over the corners readable at every k."));
  }
  page->add_figures(figures);
  HtmlTable table{
      .caption = "k with the least error",
      .header = {"by", "k", "E_connect"},
      .rows = {{{"model E_t"}, {fmt::format("{:g}", *r.connection.model_k_deg)}, {"-"}}}};
  for (const MeasuredConnection& each : r.connection.measured) {
    table.rows.push_back({{"measured, " + each.generation},
                          {fmt::format("{:g}", each.k_deg), true},
                          {fixed_number(each.e_connect, 2)}});
  }
  page->add_table(table);
}

void add_storage(const RoomRequirements& r, HtmlPage* page) {
  const StorageFacts& s = r.storage;
  page->add_section("Storage");
  page->add_paragraph(fmt::format(
      "Width: with the error of the distances, at half a cell ({}) and half a step, the residual "
      "parallax equals {:g} px of a panorama {} wide; a wider one stores detail that views "
      "displace by more. Distances: maps {} px wide keep {} of the directions within the tolerance "
      "at this reach, which needs {} steps of inverse distance, {} bits.",
      metres(s.reach_m), r.tolerance_px, pixels(s.worth_width_px), s.needed_distance_width_px,
      percent(s.share_within_tolerance), s.omega_steps, s.omega_bits));
  page->add_table({.caption = "Bytes",
                   .header = {"what", "bytes", "of the original"},
                   .rows = {{{"rays as captured"}, {megabytes(s.ray_bytes)}, {"100.0 %"}},
                            {{"rays of the stations needed"},
                             {megabytes(s.ray_bytes_thinned)},
                             {share_of(s.ray_bytes_thinned, s.ray_bytes)}},
                            {{"... at the width worth storing"},
                             {megabytes(s.ray_bytes_worth)},
                             {share_of(s.ray_bytes_worth, s.ray_bytes)}},
                            {{fmt::format("distances, {} px wide", s.distance_width_px)},
                             {megabytes(s.distance_bytes)},
                             {"100.0 %"}},
                            {{fmt::format("distances, {} px wide, {} bits",
                                          s.needed_distance_width_px, s.omega_bits)},
                             {megabytes(s.distance_bytes_needed)},
                             {share_of(s.distance_bytes_needed, s.distance_bytes)}}}});
}

void add_thinned(const ThinnedFacts& t, HtmlPage* page) {
  page->add_section("The thinned room");
  page->add_table({.caption = t.room,
                   .header = {"stations", "distance maps", "bytes", "dropped ones re-created",
                              "mean PSNR", "worst PSNR"},
                   .rows = {{{std::to_string(t.stations)},
                             {std::to_string(t.distance_maps)},
                             {megabytes(t.bytes)},
                             {std::to_string(t.views)},
                             {fixed_number(t.psnr_db, 1) + " dB"},
                             {fixed_number(t.worst_psnr_db, 1) + " dB"}}}});
}

}  // namespace

std::string requirements_page(const Room& room, const RoomRequirements& requirements,
                              const KeptStations& needed) {
  HtmlPage page(
      "What " + room.directory().string() + " requires",
      fmt::format("{} lines, {} stations of {} x {} px, for a tolerance of {:g} px",
                  room.grid().lines.size(), requirements.spacing.stations, room.panorama().width,
                  room.panorama().height, requirements.tolerance_px));
  add_facts(room, requirements, &page);
  add_scene(room, requirements, needed, &page);
  add_layers(requirements, &page);
  add_spacing(requirements, &page);
  add_connection(room, requirements, &page);
  add_storage(requirements, &page);
  if (requirements.thinned) add_thinned(*requirements.thinned, &page);
  return page.html();
}

}  // namespace raywalk::build_lf
