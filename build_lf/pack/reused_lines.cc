#include "build_lf/pack/reused_lines.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "build_lf/pack/distance_sets.h"
#include "build_lf/pack/pack_room.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"
#include "core/room/hdf5_file.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr int kInputsVersion = 1;

// Without the folder, so that a folder that was moved or linked elsewhere is the same input.
std::string file_text(const fs::path& file) {
  return fmt::format("{}\n{}\n", file.filename().string(), stamp_of(file).text());
}

std::string rays_text(const Line& line, const std::vector<StationSource>& sources,
                      const PackPlan& plan) {
  std::string text =
      fmt::format("rays {} {} {} {} {} {}\n", kRoomFormatVersion, kVolumeFormatVersion, line.id,
                  plan.panorama.width, plan.panorama.height, name_of(plan.form));
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const StationSource& source = sources[i];
    const auto& position_m = line.stations[i].position_m;
    text += fmt::format("{} {} {} {}\n", line.stations[i].file, position_m[0], position_m[1],
                        position_m[2]);
    if (source.attitude) {
      text += fmt::format("attitude {} {} {}\n", source.attitude->yaw_rad,
                          source.attitude->pitch_rad, source.attitude->roll_rad);
    }
    text += file_text(source.panorama);
    if (source.mask) text += "mask " + file_text(*source.mask);
  }
  return text;
}

std::string distances_text(const Line& line, const std::vector<StationSource>& sources,
                           const PackPlan& plan) {
  const PanoramaSize map = plan.distance_map;
  std::string text = fmt::format("distances {} {} {} {} {}\n", kRoomFormatVersion, sha256_of(line),
                                 map.width, map.height, plan.form.compressed());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const StationSource& source = sources[i];
    if (!source.distance_map) continue;
    text += fmt::format("{}\n", i) + file_text(*source.distance_map);
    // Maps are turned as their panoramas are.
    if (source.attitude) {
      text += fmt::format("attitude {} {} {}\n", source.attitude->yaw_rad,
                          source.attitude->pitch_rad, source.attitude->roll_rad);
    }
  }
  return text;
}

// What inputs.json says, by the id of the line; nothing if there is none or it cannot be read.
std::map<std::string, LineInputs> read_inputs(const fs::path& room) {
  std::map<std::string, LineInputs> inputs;
  const CheckedJson document = CheckedJson::read(line_inputs_path(room));
  document.require_version(kInputsVersion);
  for (const auto& [id, line] : document.at("lines").members()) {
    inputs[id] = {line.at("rays").text(),
                  line.has("distances") ? line.at("distances").text() : std::string()};
  }
  return inputs;
}

// Complete when it appears, under its name, in `target`.
void take_over(const fs::path& volume, const fs::path& target) {
  throw_if_interrupted();
  std::error_code error;
  fs::create_hard_link(volume, target, error);
  if (!error) return;
  AtomicFile copy(target);
  fs::copy_file(volume, copy.temporary_path(), error);
  if (error) {
    throw Error(
        fmt::format("cannot copy {} to {}: {}", volume.string(), target.string(), error.message()));
  }
  copy.commit();
}

// A room that volumes are taken from.
struct EarlierRoom {
  fs::path directory{};
  std::map<std::string, LineInputs> inputs{};
  std::map<std::string, std::string> rays_sha256{};  // by the id of the line
  std::optional<fs::path> given{};                   // the directory of its given distances
};

std::optional<EarlierRoom> open_earlier(const fs::path& directory) {
  std::error_code error;
  if (!fs::exists(line_inputs_path(directory), error)) return std::nullopt;
  try {
    EarlierRoom earlier{directory, read_inputs(directory)};
    const RoomManifest manifest = read_manifest(directory);
    for (std::size_t i = 0; i < manifest.rays_sha256.size(); ++i) {
      earlier.rays_sha256[manifest.grid.lines[i].id] = manifest.rays_sha256[i];
    }
    for (const FoundDistances& found : find_distances(directory, manifest)) {
      if (found.kind == DistanceKind::kGiven && found.fault.empty()) earlier.given = found.folder;
    }
    return earlier;
  } catch (const Error& unusable) {
    spdlog::warn("packs every line anew: {}", unusable.what());
    return std::nullopt;
  }
}

// Whether the volume holds the rays that the manifest of its room names.
bool is_intact(const EarlierRoom& earlier, const std::string& line) {
  const auto recorded = earlier.rays_sha256.find(line);
  if (recorded == earlier.rays_sha256.end()) return false;
  try {
    return checksum_of_line(line_volume_path(earlier.directory, line)) == recorded->second;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

fs::path line_inputs_path(const fs::path& room) { return room / "inputs.json"; }

LineInputs line_inputs(const PackPlan& plan, std::size_t line) {
  throw_if_interrupted();
  const Line& of_grid = plan.grid.lines[line];
  LineInputs inputs{.rays = sha256_hex(rays_text(of_grid, plan.sources[line], plan))};
  if (plan.has_maps()) {
    inputs.distances = sha256_hex(distances_text(of_grid, plan.sources[line], plan));
  }
  return inputs;
}

namespace {

std::string inputs_text(const PackPlan& plan) {
  nlohmann::ordered_json lines = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < plan.grid.lines.size(); ++i) {
    const LineInputs& inputs = plan.inputs[i];
    nlohmann::ordered_json line = {{"rays", inputs.rays}};
    if (!inputs.distances.empty()) line["distances"] = inputs.distances;
    lines[plan.grid.lines[i].id] = std::move(line);
  }
  return json_text({{"format_version", kInputsVersion}, {"lines", lines}});
}

}  // namespace

void write_line_inputs(const fs::path& room, const PackPlan& plan) {
  write_file_atomically(line_inputs_path(room), inputs_text(plan));
}

bool is_packed_from(const fs::path& room, const PackPlan& plan) {
  std::error_code error;
  return fs::exists(manifest_path(room), error) && fs::exists(line_inputs_path(room), error) &&
         read_file(line_inputs_path(room)) == inputs_text(plan);
}

ReusedVolumes reuse_volumes(const fs::path& earlier, const PackPlan& plan, IndexRange lines,
                            const fs::path& room) {
  ReusedVolumes reused;
  const std::optional<EarlierRoom> from = open_earlier(earlier);
  if (!from) return reused;
  for (std::size_t i = lines.begin; i < lines.end; ++i) {
    const std::string& id = plan.grid.lines[i].id;
    const auto of_earlier = from->inputs.find(id);
    if (of_earlier == from->inputs.end()) continue;
    const LineInputs& inputs = plan.inputs[i];
    const fs::path rays = line_volume_path(room, id);
    if (of_earlier->second.rays == inputs.rays && !fs::exists(rays) && is_intact(*from, id)) {
      take_over(line_volume_path(from->directory, id), rays);
      ++reused.lines;
    }
    const fs::path distances = distance_volume_path(room, id);
    if (!inputs.distances.empty() && of_earlier->second.distances == inputs.distances &&
        from->given && !fs::exists(distances)) {
      take_over(*from->given / distances.filename(), distances);
      ++reused.distances;
    }
  }
  return reused;
}

std::string measurements_of(const fs::path& room) {
  constexpr std::array<std::pair<const char*, const char*>, 5> kMeasurements{
      {{"depth.json", "estimated distances"},
       {"gains.h5", "gains"},
       {"held-out", "held-out stations"},
       {"require.json", "requirements"},
       {"measured.json", "measured settings"}}};
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& [file, what] : kMeasurements) {
    if (fs::exists(room / file, error)) found.emplace_back(what);
  }
  return fmt::format("{}", fmt::join(found, ", "));
}

}  // namespace raywalk::build_lf
