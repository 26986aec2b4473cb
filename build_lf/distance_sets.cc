#include "build_lf/distance_sets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <vector>

#include "build_lf/distances_lock.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"
#include "core/room/connection_errors.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

void write_manifest(const fs::path& room, const RoomManifest& manifest) {
  write_file_atomically(manifest_path(room), manifest_to_json(manifest));
}

// Measurements made with other distances are no longer valid. Returns whether there were any.
bool remove_measurements(const fs::path& room) {
  std::error_code ignored;
  return fs::remove(connection_errors_path(room), ignored);
}

// Adds the checksums of files to sets of a room whose manifest did not record them.
void complete_checksums(std::optional<FoundDistances>* found) {
  if (!*found || !(*found)->set.volumes.front().sha256.empty()) return;
  add_file_checksums((*found)->directory, &(*found)->set);
}

void add_set(const std::optional<FoundDistances>& found, std::vector<DistanceSet>* sets) {
  if (found) sets->push_back(found->set);
}

std::vector<DistanceSet> sets_of(const RoomDistances& distances) {
  std::vector<DistanceSet> sets;
  add_set(distances.given, &sets);
  add_set(distances.estimated, &sets);
  return sets;
}

std::string description_of(const FoundDistances& found) {
  std::size_t maps = 0;
  std::uint64_t bytes = 0;
  for (const DistanceVolumeRecord& volume : found.set.volumes) {
    maps += static_cast<std::size_t>(volume.maps);
    bytes += volume.bytes;
  }
  const PanoramaSize size = found.set.volumes.front().size;
  return fmt::format("  {:<20} {:<11} {} of {} x {} on {}, {:.1f} MB, in {}\n", found.set.origin,
                     found.in_use ? "in use" : "not in use", counted(maps, "map"), size.width,
                     size.height, counted(found.set.volumes.size(), "line"),
                     static_cast<double>(bytes) * 1e-6, found.directory.string());
}

[[noreturn]] void throw_unusable(const fs::path& room, const std::string& fault) {
  throw Error(
      fmt::format("{}; put the room's own file back, or accept what is there "
                  "(`raywalk-build-lf distances {} --record`)",
                  fault, room.string()));
}

// Throws Error if the set of a kind is not there.
const FoundDistances& require_found(const RoomDistances& distances, DistanceKind kind,
                                    const fs::path& room) {
  if (distances.found(kind)) return *distances.found(kind);
  if (!distances.fault(kind).empty()) throw_unusable(room, distances.fault(kind));
  throw Error(
      kind == DistanceKind::kGiven
          ? room.string() + ": no given distances; pack the room with --distance"
          : fmt::format("{}: no estimated distances; `raywalk-build-lf depth {}` makes them",
                        room.string(), room.string()));
}

bool nothing_in(const fs::path& directory) {
  std::error_code error;
  return !fs::exists(directory, error) || fs::is_empty(directory, error);
}

// Renames `wanted` to ROOM/distances, and what is there to `kept`.
void swap_in(const fs::path& room, const fs::path& wanted, const fs::path& kept) {
  const fs::path place = distances_directory(room);
  if (nothing_in(place)) {
    rename_or_throw(wanted, place);
  } else if (!exchange(wanted, place)) {
    rename_or_throw(place, kept);
    rename_or_throw(wanted, place);
  } else if (kept != wanted) {
    rename_or_throw(wanted, kept);
  }
}

// The given set to stay recorded while estimated ones are replaced: also one whose files are
// damaged, so that this is not forgotten.
std::vector<DistanceSet> given_sets(const fs::path& room, const RoomManifest& manifest,
                                    const RoomDistances& found) {
  std::vector<DistanceSet> given;
  add_set(found.given, &given);
  if (!given.empty() || !manifest.distances ||
      nothing_in(kept_directory(room, DistanceKind::kGiven))) {
    return given;
  }
  std::ranges::copy_if(*manifest.distances, std::back_inserter(given), &DistanceSet::given);
  return given;
}

}  // namespace

std::string distances_text(const fs::path& room) {
  const RoomDistances distances = find_distances(room, read_manifest(room));
  if (!distances.in_use_fault.empty()) throw_unusable(room, distances.in_use_fault);
  const FoundDistances* in_use = distances.in_use();
  std::string text = room.string() + ": ";
  text += in_use == nullptr
              ? "no distances are in use; `raywalk-build-lf depth` estimates them\n"
              : fmt::format("views use the {} distances\n", name_of(kind_of(in_use->set)));
  for (const DistanceKind kind : {DistanceKind::kGiven, DistanceKind::kEstimated}) {
    if (distances.found(kind)) text += description_of(*distances.found(kind));
    if (!distances.fault(kind).empty()) {
      text += fmt::format("  {:<20} not usable  {}\n", name_of(kind), distances.fault(kind));
    }
  }
  if (distances.given && distances.estimated) {
    text += fmt::format("`raywalk-build-lf distances {} --use {}` switches\n", room.string(),
                        in_use == &*distances.given ? "estimated" : "given");
  }
  return text;
}

std::string use_distances(const fs::path& room, DistanceKind kind) {
  read_manifest(room);  // refuses what is not a room before a lock is made in it
  const DistancesLock lock(room);
  RoomManifest manifest = read_manifest(room);
  RoomDistances distances = find_distances(room, manifest);
  const FoundDistances& wanted = require_found(distances, kind, room);
  const std::string name = name_of(kind);
  if (wanted.in_use) {
    return fmt::format("{}: views already use the {} distances", room.string(), name);
  }
  const fs::path kept = kept_directory(room, other_than(kind));
  if (kept != wanted.directory && !nothing_in(kept)) {
    // What is there is not recorded, or it would have been found.
    if (distances.in_use() == nullptr) throw_unusable(room, distances.in_use_fault);
    fs::remove_all(kept);
  }
  if (!manifest.distances) {
    complete_checksums(&distances.given);
    complete_checksums(&distances.estimated);
    manifest.distances = sets_of(distances);
    write_manifest(room, manifest);
  }
  const bool measured = remove_measurements(room);
  swap_in(room, wanted.directory, kept);
  return fmt::format(
      "{}: views now use the {} distances{}", room.string(), name,
      measured ? "; connect-error.json was measured with the others and is removed" : "");
}

std::string record_distances(const fs::path& room) {
  read_manifest(room);
  const DistancesLock lock(room);
  RoomManifest manifest = read_manifest(room);
  manifest.distances.emplace();
  std::vector<std::string> recorded;
  for (const fs::path& directory :
       {distances_directory(room), kept_directory(room, DistanceKind::kGiven),
        kept_directory(room, DistanceKind::kEstimated)}) {
    std::optional<DistanceSet> set =
        set_of(open_distance_volumes(directory, manifest.grid), manifest.grid);
    if (!set) continue;
    add_file_checksums(directory, &*set);
    recorded.push_back(fmt::format("those in {} ({})", directory.string(), set->origin));
    if (manifest.distances->empty() && directory != distances_directory(room)) {
      throw Error(
          fmt::format("{}: holds no distances, but {} does; put those in use with "
                      "`raywalk-build-lf distances {} --use {}`",
                      distances_directory(room).string(), directory.string(), room.string(),
                      name_of(kind_of(*set))));
    }
    manifest.distances->push_back(std::move(*set));
  }
  remove_measurements(room);
  write_manifest(room, manifest);
  return fmt::format("{}: recorded as its distances: {}", room.string(),
                     recorded.empty() ? "none" : fmt::format("{}", fmt::join(recorded, ", ")));
}

void require_distances_replaceable(const fs::path& room) {
  const RoomManifest manifest = read_manifest(room);
  const RoomDistances distances = find_distances(room, manifest);
  if (distances.in_use_fault.empty() || distances.given) return;
  const bool may_be_given = !manifest.distances || !distances.given_fault.empty();
  if (may_be_given && !nothing_in(distances_directory(room))) {
    throw Error(fmt::format(
        "{}; these may be the given distances, which depth keeps: put them back, or remove {} to "
        "go on without them",
        distances.in_use_fault, distances_directory(room).string()));
  }
  spdlog::warn("{}; new ones take their place", distances.in_use_fault);
}

void replace_estimated(const fs::path& room, const fs::path& volumes,
                       const std::function<void(const std::string& keep_as)>& move_in) {
  const DistancesLock lock(room);
  require_distances_replaceable(room);
  RoomManifest manifest = read_manifest(room);
  RoomDistances before = find_distances(room, manifest);
  complete_checksums(&before.given);
  complete_checksums(&before.estimated);
  std::optional<DistanceSet> added =
      set_of(open_distance_volumes(volumes, manifest.grid), manifest.grid);
  if (!added) throw Error(volumes.string() + ": no distance map was estimated");
  add_file_checksums(volumes, &*added);

  std::vector<DistanceSet> kept = given_sets(room, manifest, before);
  manifest.distances = kept;
  add_set(before.estimated, &*manifest.distances);
  manifest.distances->push_back(*added);
  write_manifest(room, manifest);
  remove_measurements(room);
  const bool keep = before.given && before.given->in_use;
  move_in(keep ? kept_directory(room, DistanceKind::kGiven).filename().string() : "");
  kept.push_back(std::move(*added));
  manifest.distances = std::move(kept);
  write_manifest(room, manifest);
  const fs::path stale = kept_directory(room, DistanceKind::kEstimated);
  std::error_code ignored;
  if (!before.given || before.given->directory != stale) fs::remove_all(stale, ignored);
}

}  // namespace raywalk::build_lf
