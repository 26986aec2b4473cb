#include "core/room/distance_record.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <system_error>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/fingerprint.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

bool same_volume(const DistanceVolumeRecord& a, const DistanceVolumeRecord& b) {
  return a.line == b.line && a.maps == b.maps && a.size == b.size && a.bytes == b.bytes &&
         a.header_sha256 == b.header_sha256;
}

const DistanceVolumeRecord* volume_of(const DistanceSet& set, const std::string& line) {
  const auto found = std::ranges::find(set.volumes, line, &DistanceVolumeRecord::line);
  return found == set.volumes.end() ? nullptr : &*found;
}

std::ptrdiff_t volumes_alike(const DistanceSet& recorded, const DistanceSet& found) {
  return std::ranges::count_if(recorded.volumes, [&](const DistanceVolumeRecord& volume) {
    const DistanceVolumeRecord* other = volume_of(found, volume.line);
    return other != nullptr && same_volume(volume, *other);
  });
}

// Of equally similar sets the last, which was recorded last.
const DistanceSet& most_alike(std::span<const DistanceSet> recorded, const DistanceSet& found) {
  const DistanceSet* best = &recorded.front();
  for (const DistanceSet& set : recorded) {
    if (volumes_alike(set, found) >= volumes_alike(*best, found)) best = &set;
  }
  return *best;
}

}  // namespace

std::string origin_of(std::span<const DistanceVolume> volumes) {
  std::vector<std::string> origins;
  for (const DistanceVolume& volume : volumes) {
    if (volume.maps() > 0 && std::ranges::find(origins, volume.origin()) == origins.end()) {
      origins.push_back(volume.origin());
    }
  }
  return origins.empty() ? "none" : fmt::format("{}", fmt::join(origins, " and "));
}

std::vector<DistanceVolume> open_distance_volumes(const fs::path& directory, const Grid& grid) {
  std::vector<DistanceVolume> volumes;
  for (const Line& line : grid.lines) {
    const fs::path file = directory / (line.id + ".h5");
    std::error_code error;
    volumes.push_back(fs::exists(file, error)
                          ? DistanceVolume::open(file, static_cast<int>(line.stations.size()))
                          : DistanceVolume());
    const std::string& holds = volumes.back().line();
    if (!holds.empty() && holds != line.id) {
      throw Error(fmt::format("{}: holds the distances of line {}", file.string(), holds));
    }
  }
  return volumes;
}

std::optional<DistanceSet> set_of(std::span<const DistanceVolume> volumes, const Grid& grid) {
  DistanceSet set{.origin = origin_of(volumes)};
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const DistanceVolume& volume = volumes[i];
    if (volume.maps() == 0) continue;
    set.volumes.push_back({.line = grid.lines[i].id,
                           .maps = volume.maps(),
                           .size = volume.size(),
                           .bytes = volume.bytes(),
                           .header_sha256 = volume.header_sha256()});
  }
  if (set.volumes.empty()) return std::nullopt;
  return set;
}

void add_file_checksums(const fs::path& directory, DistanceSet* set) {
  const int count = static_cast<int>(set->volumes.size());
  Progress progress("checksums of distances", count, "volumes");
  parallel_for(0, count, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      DistanceVolumeRecord& volume = set->volumes[static_cast<std::size_t>(i)];
      volume.sha256 = sha256_of_file(directory / (volume.line + ".h5"));
      progress.advance();
    }
  });
}

const DistanceSet* recorded_as(std::span<const DistanceSet> recorded, const DistanceSet& found) {
  const auto same = std::ranges::find_if(recorded, [&](const DistanceSet& set) {
    return set.origin == found.origin && set.volumes.size() == found.volumes.size() &&
           volumes_alike(set, found) == std::ssize(found.volumes);
  });
  return same == recorded.end() ? nullptr : &*same;
}

std::optional<std::string> difference_from_record(std::span<const DistanceSet> recorded,
                                                  const std::optional<DistanceSet>& found,
                                                  const fs::path& directory) {
  const auto file_of = [&](const std::string& line) {
    return (directory / (line + ".h5")).string();
  };
  if (recorded.empty() && !found) return std::nullopt;
  if (!found) return directory.string() + ": the recorded distances are missing";
  if (recorded_as(recorded, *found) != nullptr) return std::nullopt;
  const DistanceSet none;
  const DistanceSet& set = recorded.empty() ? none : most_alike(recorded, *found);
  for (const DistanceVolumeRecord& volume : found->volumes) {
    if (volume_of(set, volume.line) == nullptr) {
      return file_of(volume.line) + ": not recorded in the room's manifest";
    }
  }
  for (const DistanceVolumeRecord& volume : set.volumes) {
    const DistanceVolumeRecord* other = volume_of(*found, volume.line);
    if (other == nullptr) return file_of(volume.line) + ": the recorded distances are missing";
    if (!same_volume(volume, *other)) {
      return file_of(volume.line) + ": not the distances that the room's manifest records";
    }
  }
  return fmt::format("{}: the maps are {}, but the room's manifest says {}", directory.string(),
                     found->origin, set.origin);
}

}  // namespace raywalk
