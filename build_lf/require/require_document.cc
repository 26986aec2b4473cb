#include "build_lf/require/require_document.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/pick_evenly.h"
#include "core/room/requirements.h"
#include "core/view/map_choice.h"

namespace raywalk::build_lf {

// Members are keys of the same names. By the library's own macro, which has no optional values.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LayersAtDistance, d_p_m, layers)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LayerFacts, inverse_min_per_m, inverse_max_per_m, by_d_p)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SpacingWithLayers, layers, needed_m)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HeldOutFacts, stride, step_m, views, psnr_with_distances_db,
                                   psnr_without_depth_db, psnr_of_tolerance_db, hidden_share)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SpacingFacts, captured_median_m, captured_max_m,
                                   needed_without_depth_m, needed_with_layers, needed_by_error_m,
                                   measured_up_to_m, needed_with_distances_m, stations,
                                   stations_needed_without_depth, stations_needed_with_distances,
                                   held_out)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StorageFacts, reach_m, panorama_width_px, worth_width_px,
                                   distance_width_px, needed_distance_width_px,
                                   share_within_tolerance, inverse_steps, inverse_bits, ray_bytes,
                                   ray_bytes_thinned, ray_bytes_worth, distance_bytes,
                                   distance_bytes_needed)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ThinnedFacts, room, stations, distance_maps, bytes, views,
                                   psnr_db, worst_psnr_db)

static void to_json(nlohmann::json& json, const DistanceFacts& f) {
  json = {
      {"near_m", f.near_m},       {"median_m", f.median_m},       {"far_m", f.far_m},
      {"sky_share", f.sky_share}, {"known_share", f.known_share}, {"inverse_error_per_m", nullptr}};
  if (f.inverse_error_per_m) json["inverse_error_per_m"] = *f.inverse_error_per_m;
}

namespace {

using Json = nlohmann::ordered_json;

Json stations_of(const Grid& grid, const KeptStations& kept) {
  Json stations = Json::array();
  for (size_t line = 0; line < grid.lines.size(); ++line) {
    const std::vector<Station>& of_line = grid.lines[line].stations;
    for (size_t s = 0; s < of_line.size(); ++s) {
      stations.push_back({{"line", grid.lines[line].id},
                          {"station", s},
                          {"x_m", of_line[s].position_m.x()},
                          {"z_m", of_line[s].position_m.z()},
                          {"kept", std::ranges::binary_search(kept[line], static_cast<int>(s))}});
    }
  }
  return stations;
}

// What some maps see around them at their own height: distances by longitude, from the back over
// the left, evenly; null for no surface.
Json surroundings_of(const Room& room) {
  constexpr int kMostMaps = 8;
  constexpr int kDirections = 180;
  const std::vector<MapStation> maps = all_maps(room);
  Json surroundings = Json::array();
  for (const int i : pick_evenly(static_cast<int>(maps.size()), kMostMaps)) {
    const MapStation& map = maps[static_cast<size_t>(i)];
    const DistanceVolume& volume = room.distances(map.line);
    const auto [width, height] = volume.size();
    Json distances_m = Json::array();
    for (int direction = 0; direction < kDirections; ++direction) {
      const int theta = (2 * direction + 1) * width / (2 * kDirections);
      const auto row = static_cast<size_t>(height / 2);
      const float distance_m = volume.distance_column(map.map, theta)[row];
      const bool known = volume.confidence_column(map.map, theta)[row] > 0 && distance_m > 0.0f;
      distances_m.push_back(known && std::isfinite(distance_m)
                                ? Json(std::round(1000.0 * distance_m) / 1000.0)
                                : Json(nullptr));
    }
    surroundings.push_back({{"x_m", map.position_m.x()},
                            {"z_m", map.position_m.z()},
                            {"distances_m", std::move(distances_m)}});
  }
  return surroundings;
}

}  // namespace

Json require_document(const Room& room, const SceneFacts& facts, const KeptStations& kept) {
  return {{"format", kRequirementsFormat},
          {"format_version", kRequirementsVersion},
          {"distances", room.distances_origin()},
          {"distances_sha256", distances_sha256(room)},
          {"tolerance_px", facts.tolerance_px},
          {"distance", nlohmann::json(facts.distance)},
          {"layers", nlohmann::json(facts.layers)},
          {"spacing", nlohmann::json(facts.spacing)},
          {"storage", nlohmann::json(facts.storage)},
          {"thinned", facts.thinned ? nlohmann::json(*facts.thinned) : nlohmann::json()},
          {"room", room.directory().string()},
          {"lines", room.grid().lines.size()},
          {"stations", stations_of(room.grid(), kept)},
          {"surroundings", surroundings_of(room)}};
}

}  // namespace raywalk::build_lf
