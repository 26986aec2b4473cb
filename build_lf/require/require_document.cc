#include "build_lf/require/require_document.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "build_lf/pack/room_maps.h"
#include "core/base/pick_evenly.h"
#include "core/room/requirements.h"

namespace raywalk::build_lf {
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

Json json_of(const DistanceFacts& f) {
  Json error = f.omega_error_per_m ? Json(*f.omega_error_per_m) : Json(nullptr);
  return {{"near_m", f.near_m},
          {"median_m", f.median_m},
          {"far_m", f.far_m},
          {"sky_share", f.sky_share},
          {"known_share", f.known_share},
          {"omega_error_per_m", std::move(error)}};
}

Json json_of(const LayerFacts& f) {
  Json by_d_p = Json::array();
  for (const auto& [d_p_m, layers] : f.by_d_p) {
    by_d_p.push_back({{"d_p_m", d_p_m}, {"layers", layers}});
  }
  return {{"omega_min_per_m", f.omega_min_per_m},
          {"omega_max_per_m", f.omega_max_per_m},
          {"by_d_p", std::move(by_d_p)}};
}

Json json_of(const SpacingFacts& f) {
  Json with_layers = Json::array();
  for (const auto& [layers, needed_m] : f.needed_with_layers) {
    with_layers.push_back({{"layers", layers}, {"needed_m", needed_m}});
  }
  Json held_out = Json::array();
  for (const HeldOutFacts& of_stride : f.held_out) {
    held_out.push_back({{"stride", of_stride.stride},
                        {"step_m", of_stride.step_m},
                        {"views", of_stride.views},
                        {"psnr_with_distances_db", of_stride.psnr_with_distances_db},
                        {"psnr_without_depth_db", of_stride.psnr_without_depth_db},
                        {"psnr_of_tolerance_db", of_stride.psnr_of_tolerance_db},
                        {"hidden_share", of_stride.hidden_share}});
  }
  return {{"captured_median_m", f.captured_median_m},
          {"captured_max_m", f.captured_max_m},
          {"needed_without_depth_m", f.needed_without_depth_m},
          {"needed_with_layers", std::move(with_layers)},
          {"needed_by_error_m", f.needed_by_error_m},
          {"measured_up_to_m", f.measured_up_to_m},
          {"needed_with_distances_m", f.needed_with_distances_m},
          {"stations", f.stations},
          {"stations_needed_without_depth", f.stations_needed_without_depth},
          {"stations_needed_with_distances", f.stations_needed_with_distances},
          {"held_out", std::move(held_out)}};
}

Json json_of(const StorageFacts& f) {
  return {{"reach_m", f.reach_m},
          {"panorama_width_px", f.panorama_width_px},
          {"worth_width_px", f.worth_width_px},
          {"distance_width_px", f.distance_width_px},
          {"needed_distance_width_px", f.needed_distance_width_px},
          {"share_within_tolerance", f.share_within_tolerance},
          {"omega_steps", f.omega_steps},
          {"omega_bits", f.omega_bits},
          {"ray_bytes", f.ray_bytes},
          {"ray_bytes_thinned", f.ray_bytes_thinned},
          {"ray_bytes_worth", f.ray_bytes_worth},
          {"distance_bytes", f.distance_bytes},
          {"distance_bytes_needed", f.distance_bytes_needed}};
}

}  // namespace

Json json_of(const ThinnedFacts& f) {
  return {{"room", f.room},
          {"stations", f.stations},
          {"distance_maps", f.distance_maps},
          {"bytes", f.bytes},
          {"views", f.views},
          {"psnr_db", f.psnr_db},
          {"worst_psnr_db", f.worst_psnr_db}};
}

Json require_document(const Room& room, const SceneFacts& facts, const KeptStations& kept) {
  return {{"format", kRequirementsFormat},
          {"format_version", kRequirementsVersion},
          {"distances", room.distances_origin()},
          {"distances_sha256", distances_sha256(room)},
          {"tolerance_px", facts.tolerance_px},
          {"distance", json_of(facts.distance)},
          {"layers", json_of(facts.layers)},
          {"spacing", json_of(facts.spacing)},
          {"storage", json_of(facts.storage)},
          {"thinned", facts.thinned ? json_of(*facts.thinned) : Json(nullptr)},
          {"room", room.directory().string()},
          {"lines", room.grid().lines.size()},
          {"stations", stations_of(room.grid(), kept)},
          {"surroundings", surroundings_of(room)}};
}

}  // namespace raywalk::build_lf
