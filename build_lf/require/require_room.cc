#include "build_lf/require/require_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "build_lf/pack/derived_room.h"
#include "build_lf/pack/room_folder.h"
#include "build_lf/require/held_out.h"
#include "build_lf/require/require_document.h"
#include "build_lf/require/scene_facts.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/output_folder.h"
#include "core/geometry/spacing.h"
#include "core/report/report.h"
#include "core/room/kept_stations.h"
#include "core/room/requirements.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::array kLayerCounts{1, 2, 4, 8, 16, 32};

void set_captured_spacing(const Grid& grid, SpacingFacts* facts) {
  std::vector<double> steps_m;
  for (const Line& line : grid.lines) {
    facts->stations += static_cast<int>(line.stations.size());
    for (size_t i = 1; i < line.stations.size(); ++i) {
      steps_m.push_back(line.stations[i].along_m - line.stations[i - 1].along_m);
    }
  }
  facts->captured_max_m = *std::ranges::max_element(steps_m);
  facts->captured_median_m = median(std::move(steps_m));
}

int count_of(const KeptStations& kept) {
  int count = 0;
  for (const std::vector<int>& line : kept) count += static_cast<int>(line.size());
  return count;
}

SpacingFacts spacing_facts(const Room& room, const DistanceFacts& distance, InverseRange scene,
                           double tolerance_px) {
  const double tolerance_rad = angle_of_pixels(tolerance_px, room.panorama().width);
  SpacingFacts facts;
  set_captured_spacing(room.grid(), &facts);
  facts.needed_without_depth_m = spacing_needed_without_depth(scene, tolerance_rad);
  for (const int layers : kLayerCounts) {
    const double error = inverse_error_of_layers(scene, layers);
    facts.needed_with_layers.push_back({layers, spacing_needed(scene, error, tolerance_rad)});
  }
  facts.needed_by_error_m =
      distance.inverse_error_per_m
          ? spacing_needed(scene, *distance.inverse_error_per_m, tolerance_rad)
          : std::numeric_limits<double>::infinity();
  facts.held_out = measure_strides(room, facts.captured_median_m, tolerance_px);
  facts.measured_up_to_m = measured_up_to_m(facts.held_out);
  facts.needed_with_distances_m =
      std::max(facts.captured_median_m, std::min(facts.needed_by_error_m, facts.measured_up_to_m));
  facts.stations_needed_without_depth =
      count_of(needed_stations(room, facts.needed_without_depth_m));
  facts.stations_needed_with_distances =
      count_of(needed_stations(room, facts.needed_with_distances_m, Preferred::kWithDistances));
  return facts;
}

// Creates the report's directory first, so that a --thin that names it or a parent directory fails
// now, not when the finished room is renamed.
void prepare_outputs(const RequireOptions& options) {
  const AtomicFile probe(requirements_path(options.room));
  if (options.report) {
    make_directories(*options.report);
    const AtomicFile page_probe(*options.report / "index.html");
    const AtomicFile json_probe(*options.report / "require.json");
  }
  if (!options.thin) return;
  const fs::path out = without_trailing_slash(*options.thin);
  if (!options.replace_thin) {
    require_absent(out, "--thin");
  } else if (fs::exists(out)) {
    if (fs::equivalent(out, options.room)) {
      throw UsageError(fmt::format("--thin is the room {} itself; choose another directory",
                                   options.room.string()));
    }
    require_replaceable_room(out);
    return;
  }
  const AtomicFile thin_probe(out);
}

// Without any distance map the thinned room could be neither rendered with correction nor compared.
void require_kept_maps(const Room& room, const KeptStations& kept) {
  for (size_t line = 0; line < kept.size(); ++line) {
    const DistanceVolume& maps = room.distances(static_cast<int>(line));
    const auto has_map = [&](int station) { return maps.map_of(station).has_value(); };
    if (std::ranges::any_of(kept[line], has_map)) return;
  }
  throw Error(
      fmt::format("{}: no station that --thin would keep has a distance map; add maps with "
                  "raywalk-build-lf depth or pack --distance",
                  room.directory().string()));
}

std::string distance_text(double distance_m) {
  return std::isfinite(distance_m) ? fmt::format("{:.2f} m", distance_m) : "sky";
}

std::string spacing_text(double spacing_m) {
  return std::isfinite(spacing_m) ? fmt::format("{:.2f} cm", 100.0 * spacing_m) : "any";
}

// For a terminal.
std::string summary_of(const SceneFacts& r, const Room& measured, const RequireOptions& options) {
  const std::string room = escaped(options.room.string());
  std::string text = fmt::format(
      "{}: surfaces from {} to {}, for {:g} px, with distances {}:\n"
      "  layers    {} at {:.2f} m from the line\n"
      "  spacing   {} without depth, {} with distances; captured {}\n"
      "  stations  {} of {} needed with distances\n",
      room, distance_text(r.distance.near_m), distance_text(r.distance.far_m), r.tolerance_px,
      measured.distances_origin(), r.storage.inverse_steps, r.storage.reach_m,
      spacing_text(r.spacing.needed_without_depth_m),
      spacing_text(r.spacing.needed_with_distances_m), spacing_text(r.spacing.captured_median_m),
      r.spacing.stations_needed_with_distances, r.spacing.stations);
  if (r.thinned) {
    text += fmt::format(
        "  {}: {}, dropped ones re-created at {:.1f} dB\n", escaped(options.thin->string()),
        counted(static_cast<size_t>(r.thinned->stations), "station"), r.thinned->psnr_db);
  }
  return text + escaped(options.report ? (*options.report / "index.html").string()
                                       : requirements_path(options.room).string());
}

void require_tolerance(double tolerance_px) {
  if (tolerance_px >= 0.01 && tolerance_px <= 100.0) return;
  throw UsageError(fmt::format("--tolerance-px is {}; use 0.01 to 100 pixels", tolerance_px));
}

// Writes and reports what was measured.
std::string finish(const RequireOptions& options, const Room& room, SceneFacts facts) {
  const KeptStations kept =
      needed_stations(room, facts.spacing.needed_with_distances_m, Preferred::kWithDistances);
  if (options.thin) require_kept_maps(room, kept);
  Json document = require_document(room, facts, kept);
  write_file_atomically(requirements_path(options.room), json_text(document));
  if (options.thin) {
    write_thinned_room(room, kept, facts.storage.needed_distance_width_px, *options.thin,
                       options.replace_thin);
    facts.thinned = thinned_facts(room, kept, *options.thin);
    document = require_document(room, facts, kept);
    write_file_atomically(requirements_path(options.room), json_text(document));
  }
  if (options.report) {
    write_file_atomically(*options.report / "require.json", json_text(document));
    write_file_atomically(*options.report / "index.html", report_page("require", document));
  }
  return summary_of(facts, room, options);
}

}  // namespace

SceneFacts measure_requirements(const Room& room, double tolerance_px) {
  const double tolerance_rad = angle_of_pixels(tolerance_px, room.panorama().width);
  SceneFacts result{.tolerance_px = tolerance_px};
  result.distance = distance_facts(room);
  const double reach_m = typical_reach_m(room.grid());
  result.layers = layer_facts(result.distance, reach_m, tolerance_rad);
  result.spacing = spacing_facts(room, result.distance, result.layers.range(), tolerance_px);
  result.storage =
      storage_facts(room,
                    {.reach_m = reach_m,
                     .spacing_m = result.spacing.needed_with_distances_m,
                     .tolerance_px = tolerance_px,
                     .inverse_error = result.distance.inverse_error_per_m.value_or(0.0),
                     .scene = result.layers.range()},
                    result.spacing.stations_needed_with_distances);
  return result;
}

std::string require_room(const RequireOptions& options) {
  require_tolerance(options.tolerance_px);
  const Room room = Room::open(options.room);
  prepare_outputs(options);
  return finish(options, room, measure_requirements(room, options.tolerance_px));
}

}  // namespace raywalk::build_lf
