#include "build_lf/require/require_document.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/geometry/spacing.h"
#include "core/geometry/sphere.h"
#include "core/room/choose_k.h"

namespace raywalk::build_lf {
namespace {

int layers_at_reach(const RoomRequirements& r) {
  int layers = 1;
  for (const LayersAtDistance& each : r.layers.by_d_p) {
    if (each.d_p_m <= r.storage.reach_m) layers = each.layers;
  }
  return layers;
}

}  // namespace

nlohmann::ordered_json require_document(const Room& room, const RoomRequirements& r) {
  nlohmann::ordered_json document = requirements_document(r);
  document["room"] = room.directory().string();
  document["lines"] = room.grid().lines.size();
  document["tolerance_deg"] =
      degrees_from_radians(angle_of_pixels(r.tolerance_px, r.storage.panorama_width_px));
  document["distances"] = r.distances;
  document["layers"]["at_reach"] = layers_at_reach(r);
  document["storage"]["panorama_height_px"] = room.panorama().height;
  document["distance"]["error_at_median_m"] = nullptr;
  if (r.distance.omega_error_per_m) {
    document["distance"]["error_at_median_m"] =
        *r.distance.omega_error_per_m * r.distance.median_m * r.distance.median_m;
  }
  nlohmann::ordered_json& connection = document["connection"];
  connection["k_deg"] = nullptr;
  connection["k_source"] = nullptr;
  if (!room.grid().cells.empty()) {
    const ChosenK chosen = choose_k(room, "hlf-vd");
    connection["k_deg"] = chosen.k_deg;
    connection["k_source"] = chosen.source;
  }
  return document;
}

}  // namespace raywalk::build_lf
