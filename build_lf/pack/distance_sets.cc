#include "build_lf/pack/distance_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "build_lf/pack/distances_lock.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

std::string text_of(const FoundDistances& found) {
  if (!found.fault.empty()) {
    return fmt::format("  {:<20} not usable  {}\n", name_of(found.kind), found.fault);
  }
  std::size_t maps = 0, lines = 0;
  PanoramaSize size;
  for (const DistanceVolume& volume : found.volumes) {
    if (volume.maps() == 0) continue;
    maps += static_cast<std::size_t>(volume.maps());
    ++lines;
    size = volume.size();
  }
  return fmt::format("  {:<20} {:<11} {} of {} x {} on {}, {:.1f} MB, in {}\n", found.origin,
                     found.in_use ? "in use" : "not in use", counted(maps, "map"), size.width,
                     size.height, counted(lines, "line"),
                     static_cast<double>(bytes_in(found.folder)) * 1e-6,
                     escaped(found.folder.string()));
}

}  // namespace

std::vector<FoundDistances> find_distances(const fs::path& room, const RoomManifest& manifest) {
  std::vector<FoundDistances> all;
  for (const DistanceKind kind : {DistanceKind::kGiven, DistanceKind::kEstimated}) {
    FoundDistances found{.kind = kind,
                         .folder = distances_directory(room, kind),
                         .in_use = manifest.distances == kind};
    std::error_code error;
    if (!found.in_use && !fs::exists(found.folder, error)) continue;
    try {
      found.volumes = open_distance_volumes(found.folder, manifest.grid);
      found.origin = origin_of(found.volumes);
    } catch (const Error& unusable) {
      found.fault = unusable.what();
    }
    all.push_back(std::move(found));
  }
  return all;
}

std::string distances_text(const fs::path& room) {
  const RoomManifest manifest = read_manifest(room);
  const std::vector<FoundDistances> all = find_distances(room, manifest);
  std::string text = escaped(room.string()) + ": ";
  text += manifest.distances == DistanceKind::kNone
              ? "no distances are in use; `raywalk-build-lf depth` estimates them\n"
              : fmt::format("views use the {} distances\n", name_of(manifest.distances));
  for (const FoundDistances& found : all) text += text_of(found);
  for (const FoundDistances& found : all) {
    if (found.in_use || !found.fault.empty()) continue;
    text += fmt::format("`raywalk-build-lf distances {} --use {}` switches\n",
                        escaped(shell_word(room.string())), name_of(found.kind));
  }
  return text;
}

DistanceKind distance_kind_from_name(const std::string& name) {
  for (const DistanceKind kind : {DistanceKind::kGiven, DistanceKind::kEstimated}) {
    if (name == name_of(kind)) return kind;
  }
  throw UsageError("--use is '" + name + "'; give given or estimated");
}

std::string use_distances(const fs::path& room, DistanceKind kind) {
  read_manifest(room);  // refuses what is not a room before a lock is made in it
  const DistancesLock lock(room);
  RoomManifest manifest = read_manifest(room);
  const fs::path folder = distances_directory(room, kind);
  std::error_code error;
  if (!fs::exists(folder, error)) {
    throw Error(
        kind == DistanceKind::kGiven
            ? room.string() + ": no given distances; pack the room with --distance"
            : fmt::format("{}: no estimated distances; `raywalk-build-lf depth {}` makes them",
                          room.string(), shell_word(room.string())));
  }
  open_distance_volumes(folder, manifest.grid);  // throws where they are damaged
  const bool already = manifest.distances == kind;
  manifest.distances = kind;
  if (!already) write_file_atomically(manifest_path(room), manifest_to_json(manifest));
  return fmt::format("{}: views {} use the {} distances", escaped(room.string()),
                     already ? "already" : "now", name_of(kind));
}

}  // namespace raywalk::build_lf
