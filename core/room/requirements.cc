#include "core/room/requirements.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>
#include <type_traits>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/files/sha256.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxRequirementsBytes = std::size_t{16} << 20;

// The keys of each object, for both writing and reading: visit(key, member).
template <typename Visit>
void visit_members(DistanceFacts& r, Visit&& visit) {
  visit("near_m", r.near_m);
  visit("median_m", r.median_m);
  visit("far_m", r.far_m);
  visit("sky_share", r.sky_share);
  visit("known_share", r.known_share);
  visit("omega_error_per_m", r.omega_error_per_m);
}
template <typename Visit>
void visit_members(LayersAtDistance& r, Visit&& visit) {
  visit("d_p_m", r.d_p_m);
  visit("layers", r.layers);
}
template <typename Visit>
void visit_members(LayerFacts& r, Visit&& visit) {
  visit("omega_min_per_m", r.omega_min_per_m);
  visit("omega_max_per_m", r.omega_max_per_m);
  visit("by_d_p", r.by_d_p);
}
template <typename Visit>
void visit_members(SpacingWithLayers& r, Visit&& visit) {
  visit("layers", r.layers);
  visit("needed_m", r.needed_m);
}
template <typename Visit>
void visit_members(HeldOutFacts& r, Visit&& visit) {
  visit("stride", r.stride);
  visit("step_m", r.step_m);
  visit("views", r.views);
  visit("psnr_with_distances_db", r.psnr_with_distances_db);
  visit("psnr_without_depth_db", r.psnr_without_depth_db);
  visit("psnr_of_tolerance_db", r.psnr_of_tolerance_db);
  visit("hidden_share", r.hidden_share);
}
template <typename Visit>
void visit_members(SpacingFacts& r, Visit&& visit) {
  visit("captured_median_m", r.captured_median_m);
  visit("captured_max_m", r.captured_max_m);
  visit("needed_without_depth_m", r.needed_without_depth_m);
  visit("needed_with_layers", r.needed_with_layers);
  visit("needed_by_error_m", r.needed_by_error_m);
  visit("measured_up_to_m", r.measured_up_to_m);
  visit("needed_with_distances_m", r.needed_with_distances_m);
  visit("stations", r.stations);
  visit("stations_needed_without_depth", r.stations_needed_without_depth);
  visit("stations_needed_with_distances", r.stations_needed_with_distances);
  visit("held_out", r.held_out);
}
template <typename Visit>
void visit_members(MeasuredConnection& r, Visit&& visit) {
  visit("generation", r.generation);
  visit("k_deg", r.k_deg);
  visit("e_connect", r.e_connect);
}
template <typename Visit>
void visit_members(ConnectionFacts& r, Visit&& visit) {
  visit("model_k_deg", r.model_k_deg);
  visit("measured", r.measured);
}
template <typename Visit>
void visit_members(StorageFacts& r, Visit&& visit) {
  visit("reach_m", r.reach_m);
  visit("panorama_width_px", r.panorama_width_px);
  visit("worth_width_px", r.worth_width_px);
  visit("distance_width_px", r.distance_width_px);
  visit("needed_distance_width_px", r.needed_distance_width_px);
  visit("share_within_tolerance", r.share_within_tolerance);
  visit("omega_steps", r.omega_steps);
  visit("omega_bits", r.omega_bits);
  visit("ray_bytes", r.ray_bytes);
  visit("ray_bytes_thinned", r.ray_bytes_thinned);
  visit("ray_bytes_worth", r.ray_bytes_worth);
  visit("distance_bytes", r.distance_bytes);
  visit("distance_bytes_needed", r.distance_bytes_needed);
}
template <typename Visit>
void visit_members(ThinnedFacts& r, Visit&& visit) {
  visit("room", r.room);
  visit("stations", r.stations);
  visit("distance_maps", r.distance_maps);
  visit("bytes", r.bytes);
  visit("views", r.views);
  visit("psnr_db", r.psnr_db);
  visit("worst_psnr_db", r.worst_psnr_db);
}
template <typename Visit>
void visit_members(RoomRequirements& r, Visit&& visit) {
  visit("distances_sha256", r.distances_sha256);
  visit("tolerance_px", r.tolerance_px);
  visit("distance", r.distance);
  visit("layers", r.layers);
  visit("spacing", r.spacing);
  visit("connection", r.connection);
  visit("storage", r.storage);
  visit("thinned", r.thinned);
}

template <typename T>
Json json_of(T& value);
template <typename T>
Json json_of(std::optional<T>& value) {
  return value ? json_of(*value) : Json(nullptr);
}
template <typename T>
Json json_of(std::vector<T>& values) {
  Json json = Json::array();
  for (T& value : values) json.push_back(json_of(value));
  return json;
}
template <typename T>
Json json_of(T& value) {
  if constexpr (std::is_same_v<T, double>) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
  } else if constexpr (std::is_class_v<T> && !std::is_same_v<T, std::string>) {
    Json json = Json::object();
    visit_members(value, [&](const char* key, auto& member) { json[key] = json_of(member); });
    return json;
  } else {
    return value;
  }
}

// Each reads a value, and throws Error if it has another type.
void read(const CheckedJson& json, double* value) {
  *value = json.number_or(std::numeric_limits<double>::infinity());
}
void read(const CheckedJson& json, int* value) { *value = json.integer(0); }
void read(const CheckedJson& json, std::uint64_t* value) { *value = json.unsigned_integer(); }
void read(const CheckedJson& json, std::string* value) { *value = json.text(); }
template <typename T>
void read(const CheckedJson& json, T* object);
template <typename T>
void read(const CheckedJson& json, std::optional<T>* value) {
  value->reset();
  if (!json.is_null()) read(json, &value->emplace());
}
template <typename T>
void read(const CheckedJson& json, std::vector<T>* values) {
  values->clear();
  for (const CheckedJson& item : json.items()) read(item, &values->emplace_back());
}
template <typename T>
void read(const CheckedJson& json, T* object) {
  visit_members(*object, [&](const char* key, auto& member) { read(json.at(key), &member); });
}

// Checks the values used in computations.
void check_values(const CheckedJson& root, const RoomRequirements& r) {
  const auto require = [](bool valid, const CheckedJson& json, const char* what) {
    if (!valid) json.fail(what);
  };
  const auto is_k = [](double k_deg) { return k_deg >= 45.0 && k_deg <= 90.0; };
  require(r.tolerance_px > 0.0 && std::isfinite(r.tolerance_px), root.at("tolerance_px"),
          "is not positive");
  require(r.layers.omega_min_per_m >= 0.0 && r.layers.omega_min_per_m <= r.layers.omega_max_per_m &&
              std::isfinite(r.layers.omega_max_per_m),
          root.at("layers"), "holds no range of inverse distances");
  const CheckedJson connection = root.at("connection");
  require(!r.connection.model_k_deg || is_k(*r.connection.model_k_deg),
          connection.at("model_k_deg"), "is not in 45..90");
  for (const CheckedJson& measured : connection.at("measured").items()) {
    measured.at("k_deg").number(45.0, 90.0);
  }
}

// The checksums of a line's maps; for a volume without checksums, one over its whole content.
std::string checksums_of(const Room& room, int line) {
  const DistanceVolume& volume = room.distances(line);
  const auto file = distance_volume_path(room.directory(), room.grid().lines[size_t(line)].id);
  const Hdf5File hdf5 = Hdf5File::open(file);
  std::string text;
  if (hdf5.has_dataset("sha256")) {
    for (const std::string& sha256 : hdf5.read_strings("sha256")) text += sha256;
    return text;
  }
  for (int map = 0; map < volume.maps(); ++map) {
    for (int theta = 0; theta < volume.size().width; ++theta) {
      text += sha256_hex(std::as_bytes(volume.distance_column(map, theta)));
      text += sha256_hex(std::as_bytes(volume.confidence_column(map, theta)));
    }
    text = sha256_hex(text);
  }
  return text;
}

}  // namespace

std::string distances_sha256(const Room& room) {
  std::string text;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    if (room.distances(line).maps() == 0) continue;
    const Line& of_line = room.grid().lines[static_cast<size_t>(line)];
    text += of_line.id;
    for (const int station : room.distances(line).stations()) {
      const Eigen::Vector3d& p = of_line.stations[static_cast<size_t>(station)].position_m;
      text += fmt::format(" {},{},{}", p.x(), p.y(), p.z());
    }
    text += " " + checksums_of(room, line) + "\n";
  }
  return sha256_hex(text);
}

std::filesystem::path requirements_path(const std::filesystem::path& room) {
  return room / "require.json";
}

Json requirements_document(const RoomRequirements& requirements) {
  Json root = {{"format", kRequirementsFormat},
               {"format_version", kRequirementsVersion},
               {"written_by", "raywalk " RAYWALK_VERSION}};
  if (!requirements.distances.empty()) root["distances"] = requirements.distances;
  RoomRequirements copy = requirements;  // visit_members needs mutable members
  root.update(json_of(copy));
  return root;
}

RoomRequirements requirements_from_json(const std::string& text, const std::string& source) {
  const CheckedJson root =
      CheckedJson::parse(text, source, "run raywalk-build-lf require on the room again");
  if (root.at("format").text() != kRequirementsFormat) {
    root.fail("not written by raywalk-build-lf require");
  }
  root.require_version(kRequirementsVersion);
  RoomRequirements requirements;
  read(root, &requirements);
  // Files of older programs lack it.
  if (root.has("distances")) requirements.distances = root.at("distances").text();
  check_values(root, requirements);
  return requirements;
}

std::optional<RoomRequirements> current_requirements(const Room& room) {
  const std::filesystem::path file = requirements_path(room.directory());
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::nullopt;
  RoomRequirements kept =
      requirements_from_json(read_file(file, kMaxRequirementsBytes), file.string());
  if (kept.distances_sha256 == distances_sha256(room)) return kept;
  spdlog::warn(
      "{} was measured with different distances and is ignored; run "
      "raywalk-build-lf require on the room again",
      file.string());
  return std::nullopt;
}

}  // namespace raywalk
