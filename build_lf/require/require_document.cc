#include "build_lf/require/require_document.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "build_lf/room_maps.h"
#include "core/base/pick_evenly.h"
#include "core/room/choose_k.h"
#include "core/room/connection_model.h"

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

// E_t over k by the model. The room must have a cell.
Json model_curve(const Room& room) {
  const ConnectionErrorCurve curve = connection_model(room).curve;
  Json points = Json::array();
  for (size_t i = 0; i < curve.total.size(); ++i) {
    points.push_back(
        {{"k_deg", ConnectionErrorCurve::kMinDeg + static_cast<int>(i)}, {"e_t", curve.total[i]}});
  }
  return points;
}

// Measured E_connect over k, of the generations that have a least one.
Json measured_curves(const Room& room) {
  Json points = Json::array();
  for (const ConnectionErrorMeasurement& each : read_connection_errors(room.directory())) {
    if (!least_error(each)) continue;
    for (const ConnectionErrorAtK& row : each.rows) {
      points.push_back({{"generation", each.generation},
                        {"k_deg", row.k_deg},
                        {"e_connect", row.e_connect_common}});
    }
  }
  return points;
}

}  // namespace

Json require_document(const Room& room, const RoomRequirements& requirements,
                      const KeptStations& kept) {
  Json document = requirements_document(requirements);
  document["room"] = room.directory().string();
  document["lines"] = room.grid().lines.size();
  document["stations"] = stations_of(room.grid(), kept);
  document["surroundings"] = surroundings_of(room);
  if (room.grid().cells.empty()) return document;
  const ChosenK chosen = choose_k(room, "hlf-vd");
  document["connection"].update({{"k_deg", chosen.k_deg},
                                 {"k_source", chosen.source},
                                 {"model_curve", model_curve(room)},
                                 {"measured_curves", measured_curves(room)}});
  return document;
}

}  // namespace raywalk::build_lf
