#include "render/presets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/geometry/line_gaps.h"
#include "core/geometry/spacing.h"
#include "core/room/distance_samples.h"
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

double spacing_of(const Grid& grid) {
  std::vector<double> spacings_m;
  for (const Line& line : grid.lines) spacings_m.push_back(covering_spacing(line));
  return median(std::move(spacings_m));
}

int widest_map(const Room& room) {
  int width = 0;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    if (room.distances(line).maps() > 0) width = std::max(width, room.distances(line).size().width);
  }
  return width;
}

// Shift of the nearest surfaces, in panorama pixels, that a view at the reach has to correct: the
// slope of (5) in layer_count.h.
double parallax_px(const SceneNumbers& scene) {
  return scene.reach_m * scene.scene.max * scene.width_px / kTwoPi;
}

// Distance in pixels between the two images of a point that the stations around the acquisition
// point show.
double ghost_px(const SceneNumbers& scene) {
  const double assumed = std::max(0.0, scene.scene.max - scene.omega_error);
  return ghost_angle(scene.spacing_m, scene.scene.max, assumed) * scene.width_px / kTwoPi;
}

Preset fast(const SceneNumbers& scene) {
  const double parallax = parallax_px(scene);
  ViewSettings settings;
  settings.options.stations_mixed = 1;
  settings.options.distance_maps = 2;
  settings.options.skip_px = 0.5;
  if (parallax > 1.0) {
    settings.options.generation = Generation::kHlfVd;
    return {settings, fmt::format("the nearest surfaces move by {:.0f} pixels over the reach of "
                                  "{:.2g} m, so views are corrected by distance",
                                  parallax, scene.reach_m)};
  }
  settings.options.generation = Generation::kInitial;
  return {settings,
          fmt::format("over the reach of {:.2g} m nothing moves by more than a pixel ({:.2f}), so "
                      "nothing is corrected",
                      scene.reach_m, parallax)};
}

Preset balanced(const SceneNumbers& scene) {
  const double ghost = ghost_px(scene);
  ViewSettings settings;
  settings.options.generation = Generation::kTwoSided;
  settings.options.second_side = SecondSide::kWhereHidden;
  settings.options.distance_maps = 2;
  settings.options.stations_mixed = ghost <= 0.5 ? 1 : 2;
  settings.options.skip_px = 0.125;
  return {settings,
          fmt::format("neighbouring stations show the nearest surfaces {:.2g} pixels "
                      "apart, so {} read",
                      ghost, settings.options.stations_mixed == 1 ? "one of them is" : "both are")};
}

Preset accurate() {
  ViewSettings settings;
  settings.options.generation = Generation::kTwoSided;
  settings.options.interpolation = Interpolation::kCubic;
  return {settings,
          "samples are cubic, from both sides and both stations wherever they see the point"};
}

}  // namespace

SceneNumbers scene_numbers(const Room& room) {
  SceneNumbers numbers{.has_distances = room.has_distances(),
                       .spacing_m = spacing_of(room.grid()),
                       .reach_m = reach_of(room.grid()),
                       .width_px = room.panorama().width};
  if (!numbers.has_distances) return numbers;
  const auto required = current_requirements(room);
  if (required) {
    numbers.scene = required->layers.range();
  } else {
    DistanceSamples samples = sample_distances(room, kSamplesPerMap);
    if (samples.samples.empty()) return numbers;  // no map has a known distance
    const auto range = distance_quantiles(samples.samples, std::array{0.01, 0.99});
    numbers.scene = {1.0 / range[1], 1.0 / range[0]};
  }
  numbers.omega_error = required && required->distance.omega_error_per_m
                            ? *required->distance.omega_error_per_m
                            : kTwoPi / (widest_map(room) * numbers.reach_m);
  return numbers;
}

Preset preset_of(const std::string& name, const SceneNumbers& scene) {
  if (std::ranges::count(kPresets, name) == 0) {
    throw UsageError(fmt::format("unknown preset '{}'; use {}", name, fmt::join(kPresets, ", ")));
  }
  Preset preset = name == "fast" ? fast(scene) : name == "balanced" ? balanced(scene) : accurate();
  if (!scene.has_distances) {
    preset.settings.options.generation = Generation::kInitial;
    preset.reason = "the room has no distances to correct by";
  }
  return preset;
}

Preset preset_settings(const ViewFlags& flags, const Room& room) {
  const ViewSettings plain = view_settings(flags);
  if (plain.preset == "none") return {plain, {}};
  const Preset preset = preset_of(plain.preset, scene_numbers(room));
  return {view_settings(flags, preset.settings),
          fmt::format("preset {}: {}", plain.preset, preset.reason)};
}

}  // namespace raywalk::render
