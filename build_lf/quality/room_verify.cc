#include "build_lf/quality/room_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "build_lf/pack/distance_sets.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/station_data.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/fingerprint.h"
#include "core/room/hdf5_file.h"
#include "core/room/refined_record.h"
#include "core/room/tiled_rays.h"

namespace raywalk::build_lf {
namespace {

// A stored checksum and the data of a line that it belongs to.
struct Check {
  int station;
  const FoundDistances* maps;  // null: rays
  int map;
  std::string expected;
};

std::vector<std::string> stored_checksums(const std::filesystem::path& file, int count) {
  std::vector<std::string> sha256 = Hdf5File::open(file).read_strings("sha256");
  if (static_cast<int>(sha256.size()) != count) {
    throw Error(
        fmt::format("{}: holds {} checksums for {} entries", file.string(), sha256.size(), count));
  }
  return sha256;
}

// The volume must be the one the manifest was written for.
void check_identity(const Room& room, int index) {
  const Line& line = room.grid().lines[static_cast<size_t>(index)];
  const std::filesystem::path file = line_volume_path(room.directory(), line.id);
  std::vector<double> positions;
  for (const Station& station : line.stations) {
    positions.insert(positions.end(), station.position_m.begin(), station.position_m.end());
  }
  if (Hdf5File::open(file).read<double>("position_m") != positions) {
    throw Error(
        fmt::format("{}: its station positions are not those of manifest.json", file.string()));
  }
  const std::vector<std::string>& expected = room.manifest().rays_sha256;
  if (!expected.empty() && checksum_of_line(file) != expected[static_cast<size_t>(index)]) {
    throw Error(fmt::format("{}: its checksums are not those of manifest.json", file.string()));
  }
}

std::vector<Check> checks_of(const Room& room, int index,
                             const std::vector<FoundDistances>& distances) {
  const Line& line = room.grid().lines[static_cast<size_t>(index)];
  const std::vector<std::string> rays =
      stored_checksums(line_volume_path(room.directory(), line.id), room.volume(index).stations());
  std::vector<Check> checks;
  checks.reserve(rays.size());
  for (const std::string& sha256 : rays) {
    checks.push_back({static_cast<int>(checks.size()), nullptr, 0, sha256});
  }
  for (const FoundDistances& found : distances) {
    const DistanceVolume& volume = found.volumes[static_cast<size_t>(index)];
    if (volume.maps() == 0) continue;
    const std::vector<std::string> maps =
        stored_checksums(found.folder / (line.id + ".h5"), volume.maps());
    for (int map = 0; map < volume.maps(); ++map) {
      const auto i = static_cast<size_t>(map);
      checks.push_back({volume.stations()[i], &found, map, maps[i]});
    }
  }
  return checks;
}

std::string actual_checksum(const Room& room, int line, const Check& check) {
  if (check.maps != nullptr) {
    return stored_distances(check.maps->volumes[static_cast<size_t>(line)], check.map).sha256;
  }
  const TileReading reading;
  const LineVolume& volume = room.volume(line);
  return checksum_of_rays(volume.columns(check.station), volume.stored_valid_rows(check.station));
}

[[noreturn]] void throw_damaged(const Room& room, int index, const Check& first,
                                std::int64_t damaged, std::int64_t checked) {
  const Line& line = room.grid().lines[static_cast<size_t>(index)];
  const bool estimated = first.maps != nullptr && first.maps->kind == DistanceKind::kEstimated;
  throw Error(fmt::format(
      "{}: line {} station {} ({}): the {} do not match their checksum; {} of {} checksums differ; "
      "{}",
      room.directory().string(), line.id, first.station,
      line.stations[static_cast<size_t>(first.station)].file,
      first.maps == nullptr ? "rays" : name_of(first.maps->kind) + " distances", damaged, checked,
      estimated ? "estimate the distances again with raywalk-build-lf depth"
                : "pack the room again"));
}

// Every volume in the directory must belong to a line of the room.
void require_no_strangers(const Grid& grid, const std::filesystem::path& directory) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(directory, error)) {
    const std::filesystem::path name = entry.path().filename();
    if (name.extension() != ".h5" || name.string().front() == '.') continue;  // temporary files
    if (std::ranges::find(grid.lines, name.stem().string(), &Line::id) == grid.lines.end()) {
      throw Error(entry.path().string() + ": belongs to no line of the room; remove it");
    }
  }
}

// The distances that are there, whole as far as their headers say.
std::vector<FoundDistances> checked_distances(const Room& room) {
  std::vector<FoundDistances> all = find_distances(room.directory(), room.manifest());
  for (const FoundDistances& found : all) {
    if (!found.fault.empty()) {
      throw Error(found.fault + "; put the room's own file back, or remove the folder");
    }
    require_no_strangers(room.grid(), found.folder);
  }
  return all;
}

}  // namespace

VerifiedCounts verify_room(const Room& room) {
  const std::vector<FoundDistances> distances = checked_distances(room);
  const int lines = static_cast<int>(room.grid().lines.size());
  VerifiedCounts counts;
  std::int64_t all = 0;
  for (const FoundDistances& found : distances) {
    if (!found.in_use) counts.kept_distances = found.origin;
    for (const DistanceVolume& volume : found.volumes) {
      all += volume.maps();
      if (found.in_use) counts.distance_maps += volume.maps();
    }
  }
  for (int line = 0; line < lines; ++line) counts.panoramas += room.volume(line).stations();
  all += counts.panoramas;
  int first_line = 0;
  std::optional<Check> first;
  std::int64_t damaged = 0;
  Progress progress("verifying", all, "images");
  // Line by line, so that the checksums of a line are all that is kept in memory.
  for (int line = 0; line < lines; ++line) {
    check_identity(room, line);
    const std::vector<Check> checks = checks_of(room, line, distances);
    std::vector<char> matches(checks.size());
    parallel_for(0, static_cast<int>(checks.size()), 1, [&](int begin, int end) {
      for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
        matches[i] = actual_checksum(room, line, checks[i]) == checks[i].expected ? 1 : 0;
        progress.advance();
      }
    });
    for (size_t i = 0; i < checks.size(); ++i) {
      if (matches[i] != 0) continue;
      ++damaged;
      if (first) continue;
      first_line = line;
      first = checks[i];
    }
  }
  if (first) throw_damaged(room, first_line, *first, damaged, all);
  return counts;
}

std::string text_of(const VerifiedCounts& counts, const Room& room) {
  const std::string kept = counts.kept_distances.empty()
                               ? ""
                               : "; those not in use (" + counts.kept_distances + ") match too";
  const std::string refined = refined_text(room);
  return fmt::format(
      "{}: {} panoramas and {} distance maps match their checksums; distances in use: {}{}{}{}{}",
      room.directory().string(), counts.panoramas, counts.distance_maps, room.distances_origin(),
      kept, room.gains().empty() ? "" : "; the gains match too", refined.empty() ? "" : "; ",
      refined);
}

}  // namespace raywalk::build_lf
