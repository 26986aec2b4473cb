#include "build_lf/room_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <span>
#include <vector>

#include "build_lf/pack_room.h"
#include "build_lf/station_data.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/sha256.h"
#include "core/room/hdf5_file.h"

namespace raywalk::build_lf {
namespace {

// A stored checksum and the data it belongs to.
struct Check {
  int line;
  int station;
  int map;  // -1: rays
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
  if (Hdf5File::open(file).read_float64("position_m") != positions) {
    throw Error(
        fmt::format("{}: its station positions are not those of manifest.json", file.string()));
  }
  const std::vector<std::string>& expected = room.manifest().rays_sha256;
  if (!expected.empty() && checksum_of_line(file) != expected[static_cast<size_t>(index)]) {
    throw Error(fmt::format("{}: its checksums are not those of manifest.json", file.string()));
  }
}

std::vector<Check> checks_of(const Room& room, int index) {
  const Line& line = room.grid().lines[static_cast<size_t>(index)];
  std::vector<Check> checks;
  checks.reserve(2 * line.stations.size());
  const std::vector<std::string> rays =
      stored_checksums(line_volume_path(room.directory(), line.id), room.volume(index).stations());
  for (int station = 0; station < room.volume(index).stations(); ++station) {
    checks.push_back({index, station, -1, rays[static_cast<size_t>(station)]});
  }
  const DistanceVolume& distances = room.distances(index);
  if (distances.maps() == 0) return checks;
  const std::vector<std::string> maps =
      stored_checksums(distance_volume_path(room.directory(), line.id), distances.maps());
  for (int map = 0; map < distances.maps(); ++map) {
    const auto i = static_cast<size_t>(map);
    checks.push_back({index, distances.stations()[i], map, maps[i]});
  }
  return checks;
}

// The columns of one station or map are contiguous in memory.
template <typename T>
std::span<const T> all_columns(std::span<const T> first_column, int columns) {
  return {first_column.data(), first_column.size() * static_cast<size_t>(columns)};
}

std::string actual_checksum(const Room& room, const Check& check) {
  if (check.map < 0) {
    const LineVolume& volume = room.volume(check.line);
    return checksum_of_rays(all_columns(volume.column(check.station, 0), volume.panorama().width),
                            volume.stored_valid_rows(check.station));
  }
  const DistanceVolume& volume = room.distances(check.line);
  return checksum_of_distances(
      all_columns(volume.distance_column(check.map, 0), volume.size().width),
      all_columns(volume.confidence_column(check.map, 0), volume.size().width));
}

[[noreturn]] void throw_damaged(const Room& room, const Check& first, std::size_t damaged,
                                std::size_t checked) {
  const Line& line = room.grid().lines[static_cast<size_t>(first.line)];
  throw Error(
      fmt::format("{}: line {} station {} ({}): the {} do not match their checksum; {} of {} "
                  "checksums differ; pack the room again",
                  room.directory().string(), line.id, first.station,
                  line.stations[static_cast<size_t>(first.station)].file,
                  first.map < 0 ? "rays" : "distances", damaged, checked));
}

}  // namespace

VerifiedCounts verify_room(const Room& room) {
  std::vector<Check> checks;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    check_identity(room, line);
    const std::vector<Check> of_line = checks_of(room, line);
    checks.insert(checks.end(), of_line.begin(), of_line.end());
  }
  std::mutex mutex;
  std::vector<int> damaged;
  Progress progress("verifying", static_cast<std::int64_t>(checks.size()), "images");
  parallel_for(0, static_cast<int>(checks.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Check& check = checks[static_cast<size_t>(i)];
      const bool matches = actual_checksum(room, check) == check.expected;
      progress.advance();
      const std::lock_guard lock(mutex);
      if (!matches) damaged.push_back(i);
    }
  });
  if (!damaged.empty()) {
    const int first = *std::min_element(damaged.begin(), damaged.end());
    throw_damaged(room, checks[static_cast<size_t>(first)], damaged.size(), checks.size());
  }
  const auto maps =
      std::count_if(checks.begin(), checks.end(), [](const Check& c) { return c.map >= 0; });
  return {static_cast<std::int64_t>(checks.size()) - maps, maps};
}

}  // namespace raywalk::build_lf
