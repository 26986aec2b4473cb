#include "render/view_settings.h"

#include <fmt/format.h>

#include <set>
#include <vector>

#include "core/base/error.h"
#include "core/files/number.h"
#include "core/files/settings.h"
#include "core/room/choose_k.h"
#include "core/room/requirements.h"

namespace raywalk::render {
namespace {

constexpr double kLfuKDeg = kMinK_deg;
constexpr double kRayspace360KDeg = kMaxK_deg;

SettingsSchema schema_of(ViewSettings* settings) {
  SettingsSchema schema;
  schema.choice("preset", &settings->preset, {"none", "fast", "balanced", "accurate"})
      .choice("generation", &settings->generation, {"initial", "hlf-vd", "two-sided"})
      .choice("connection", &settings->connection, {"hybrid", "lfu", "rayspace360"})
      .text("k_deg", &settings->k_deg)
      .text("layers", &settings->layers)
      .number("tolerance_px", &settings->tolerance_px, kMinTolerance_px, kMaxTolerance_px)
      .number("overlap_deg", &settings->overlap_deg, 0.0, kMaxOverlap_deg)
      .integer("width_px", &settings->width_px, 0, kMaxViewWidth_px)
      .choice("interpolation", &settings->interpolation, {"nearest", "linear", "cubic"})
      .choice("arithmetic", &settings->arithmetic, {"float", "double"})
      .choice("second_side", &settings->second_side, {"blend", "where-hidden"})
      .integer("stations_mixed", &settings->stations_mixed, 1, kMaxStationsMixed)
      .integer("station_stride", &settings->station_stride, 1, kMaxStationStride)
      .integer("distance_maps", &settings->distance_maps, 1, kMaxDistanceMaps)
      .integer("fill_stations", &settings->fill_stations, 0, kMaxFillStations)
      .number("skip_px", &settings->skip_px, 0.0, kMaxSkip_px)
      .choice("gains", &settings->gains, {"on", "off"});
  return schema;
}

template <typename T>
void override_with(const std::optional<T>& flag, T* value) {
  if (flag) *value = *flag;
}

// The k that the settings give; none where it is chosen for the room.
std::optional<double> fixed_k_deg(const ViewSettings& settings) {
  std::optional<double> k_deg;
  if (settings.k_deg != "auto") {
    k_deg = parse_finite_number(settings.k_deg);
    if (!k_deg || *k_deg < kLfuKDeg || *k_deg > kRayspace360KDeg) {
      throw UsageError(fmt::format("k is {}; use auto or degrees in {}..{}",
                                   excerpt(settings.k_deg), kLfuKDeg, kRayspace360KDeg));
    }
  }
  if (settings.connection == "hybrid") return k_deg;
  const double own_k_deg = settings.connection == "lfu" ? kLfuKDeg : kRayspace360KDeg;
  if (k_deg && *k_deg != own_k_deg) {
    throw UsageError(fmt::format("connection {} is k = {} degrees, but k is {}; use hybrid",
                                 settings.connection, own_k_deg, *k_deg));
  }
  return own_k_deg;
}

// 0 for automatic: as many as the tolerance needs.
int fixed_layers(const ViewSettings& settings) {
  if (settings.layers == "auto") return 0;
  const std::optional<int> layers = parse_whole_number(settings.layers);
  if (!layers || *layers < 1 || *layers > kMaxLayers) {
    throw UsageError(fmt::format("layers is {}; use auto or a number in 1..{}",
                                 excerpt(settings.layers), kMaxLayers));
  }
  return *layers;
}

// The command line's own checks let NaN pass.
void require_range(const char* name, double value, double min, double max) {
  if (value >= min && value <= max) return;
  throw UsageError(fmt::format("{} is {}; it must be between {} and {}", name, value, min, max));
}

void require_consistent(const ViewSettings& settings) {
  require_range("tolerance_px", settings.tolerance_px, kMinTolerance_px, kMaxTolerance_px);
  require_range("overlap_deg", settings.overlap_deg, 0.0, kMaxOverlap_deg);
  require_range("skip_px", settings.skip_px, 0.0, kMaxSkip_px);
  fixed_k_deg(settings);
  fixed_layers(settings);
}

// The room's stored requirements, if automatic layers are chosen by them.
std::optional<RoomRequirements> requirements_for(const ViewSettings& settings, const Room& room) {
  return fixed_layers(settings) == 0 ? current_requirements(room) : std::nullopt;
}

ViewMode mode_for(const ViewSettings& settings, const Room& room,
                  const RoomRequirements* required) {
  ViewMode mode;
  mode.connection = settings.connection;
  mode.options.generation = generation_from_name(settings.generation);
  mode.options.layers = fixed_layers(settings);
  if (required != nullptr) mode.options.scene = required->layers.range();
  mode.options.tolerance_px = settings.tolerance_px;
  mode.options.overlap_deg = settings.overlap_deg;
  mode.options.width = settings.width_px;
  mode.options.interpolation = interpolation_from_name(settings.interpolation);
  mode.options.arithmetic = arithmetic_from_name(settings.arithmetic);
  mode.options.second_side = second_side_from_name(settings.second_side);
  mode.options.stations_mixed = settings.stations_mixed;
  mode.options.station_stride = settings.station_stride;
  mode.options.distance_maps = settings.distance_maps;
  mode.options.fill_stations = settings.fill_stations;
  mode.options.skip_px = settings.skip_px;
  mode.options.gains = settings.gains == "on";
  if (const std::optional<double> k_deg = fixed_k_deg(settings)) {
    mode.options.k_deg = *k_deg;
    mode.k_source = settings.connection == "hybrid" ? "given" : "fixed by the connection";
  } else {
    const ChosenK chosen = choose_k(room, settings.generation);
    mode.options.k_deg = chosen.k_deg;
    mode.k_source = chosen.source;
  }
  return mode;
}

}  // namespace

ViewSettings view_settings(const ViewFlags& flags, const ViewSettings& base) {
  ViewSettings settings = base;
  if (flags.settings) {
    schema_of(&settings).load(*flags.settings);
    try {
      require_consistent(settings);
    } catch (const UsageError& e) {
      throw UsageError(flags.settings->string() + ": " + e.what());
    }
  }
  // A connection named on the command line uses its own k: the file's k belongs to the file's
  // connection.
  if (flags.connection && !flags.k_deg && *flags.connection != settings.connection) {
    settings.k_deg = "auto";
  }
  override_with(flags.preset, &settings.preset);
  override_with(flags.generation, &settings.generation);
  override_with(flags.connection, &settings.connection);
  override_with(flags.k_deg, &settings.k_deg);
  override_with(flags.layers, &settings.layers);
  override_with(flags.tolerance_px, &settings.tolerance_px);
  override_with(flags.overlap_deg, &settings.overlap_deg);
  override_with(flags.width_px, &settings.width_px);
  override_with(flags.interpolation, &settings.interpolation);
  override_with(flags.arithmetic, &settings.arithmetic);
  override_with(flags.second_side, &settings.second_side);
  override_with(flags.stations_mixed, &settings.stations_mixed);
  override_with(flags.station_stride, &settings.station_stride);
  override_with(flags.distance_maps, &settings.distance_maps);
  override_with(flags.fill_stations, &settings.fill_stations);
  override_with(flags.skip_px, &settings.skip_px);
  if (flags.no_gains) settings.gains = "off";
  require_consistent(settings);
  return settings;
}

ViewMode view_mode(const ViewSettings& settings, const Room& room) {
  const std::optional<RoomRequirements> required = requirements_for(settings, room);
  return mode_for(settings, room, required ? &*required : nullptr);
}

std::vector<ViewMode> view_modes(ViewSettings settings, std::vector<std::string> generations,
                                 const Room& room) {
  if (generations.empty()) {
    generations = {"initial"};
    if (room.has_distances()) generations.insert(generations.end(), {"hlf-vd", "two-sided"});
  }
  if (std::set(generations.begin(), generations.end()).size() != generations.size()) {
    throw UsageError("a generation is named twice; name each once");
  }
  const std::optional<RoomRequirements> required = requirements_for(settings, room);
  std::vector<ViewMode> modes;
  for (const std::string& generation : generations) {
    settings.generation = generation;
    modes.push_back(mode_for(settings, room, required ? &*required : nullptr));
  }
  return modes;
}

}  // namespace raywalk::render
