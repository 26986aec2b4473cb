#include "render/view/presets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/room/distance_maps.h"
#include "core/room/requirements.h"

namespace raywalk::render {
namespace {

constexpr int kSamplesPerMap = 4096;

double reach_of(const Grid& grid) {
  double side_m = std::numeric_limits<double>::infinity();
  for (const Cell& cell : grid.cells) {
    side_m = std::min({side_m, cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m});
  }
  if (!grid.cells.empty()) return 0.5 * side_m;
  double longest_m = 0.0;
  for (const Line& line : grid.lines) {
    longest_m = std::max(longest_m, line.last_m() - line.first_m());
  }
  return 0.5 * longest_m;
}

// Shift of the nearest surfaces, in panorama pixels, that a view at the reach has to correct: the
// slope of (5) in layer_count.h.
double parallax_px(const SceneNumbers& scene) {
  return scene.reach_m * scene.inverse_max * scene.width_px / kTwoPi;
}

Preset fast(const SceneNumbers& scene) {
  const double parallax = parallax_px(scene);
  ViewSettings settings;
  settings.options.distance_maps = 2;
  settings.options.second_side = SecondSide::kFaded;
  settings.options.station_fade = 0.125;
  if (parallax > 1.0) {
    settings.options.method = ViewMethod::kHlfVd;
    return {settings, fmt::format("the nearest surfaces move by {:.0f} pixels over the reach of "
                                  "{:.2g} m, so views are corrected by distance",
                                  parallax, scene.reach_m)};
  }
  settings.options.method = ViewMethod::kInitial;
  return {settings,
          fmt::format("over the reach of {:.2g} m nothing moves by more than a pixel ({:.2f}), so "
                      "nothing is corrected",
                      scene.reach_m, parallax)};
}

Preset balanced() {
  ViewSettings settings;
  settings.options.method = ViewMethod::kTwoSided;
  return {settings, "samples are linear, of one station on each side that sees the point"};
}

Preset accurate() {
  ViewSettings settings = balanced().settings;
  settings.options.interpolation = Interpolation::kCubic;
  settings.options.stations_mixed = 8;
  return {settings, "samples are cubic, of up to 8 stations on each side that sees the point"};
}

}  // namespace

SceneNumbers scene_numbers(const Room& room) {
  SceneNumbers numbers{.has_distances = room.has_distances(),
                       .reach_m = reach_of(room.grid()),
                       .width_px = room.panorama().width};
  if (!numbers.has_distances) return numbers;
  if (const auto required = current_requirements(room)) {
    numbers.inverse_max = required->inverse_max_per_m;
  } else {
    DistanceSamples samples = sample_distances(room, kSamplesPerMap);
    if (samples.samples.empty()) return numbers;  // no map has a known distance
    numbers.inverse_max = 1.0 / distance_quantiles(samples.samples, std::array{0.01})[0];
  }
  return numbers;
}

Preset preset_of(const std::string& name, const SceneNumbers& scene) {
  if (std::ranges::count(kPresets, name) == 0) {
    throw UsageError(fmt::format("unknown preset '{}'; use {}", name, fmt::join(kPresets, ", ")));
  }
  Preset preset = name == "fast" ? fast(scene) : name == "balanced" ? balanced() : accurate();
  if (!scene.has_distances) {
    preset.settings.options.method = ViewMethod::kInitial;
    preset.reason = "the room has no distances to correct by";
  }
  return preset;
}

void warn_without_distances(const Room& room) {
  if (room.has_distances()) return;
  const std::string name = room.directory().string();
  spdlog::warn(
      "{}: has no distances, so views are initial ones, off above and below the height of the "
      "lines; run raywalk-build-lf depth {} first",
      name, shell_word(name));
}

Preset preset_settings(const ViewFlags& flags, const Room& room) {
  const ViewSettings plain = view_settings(flags);
  if (plain.preset == "none") return {plain, {}};
  const Preset preset = preset_of(plain.preset, scene_numbers(room));
  warn_without_distances(room);
  return {view_settings(flags, preset.settings),
          fmt::format("preset {}: {}", plain.preset, preset.reason)};
}

}  // namespace raywalk::render
