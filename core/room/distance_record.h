// What manifest.json records of a room's distance volumes, so that swapped, foreign, missing and
// damaged ones are noticed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/room/distance_volume.h"

namespace raywalk {

// The distance volume of one line.
struct DistanceVolumeRecord {
  std::string line{};  // id of the line
  int maps = 0;        // at least 1
  PanoramaSize size{};
  std::uint64_t bytes = 0;      // of the file
  std::string header_sha256{};  // DistanceVolume::header_sha256()
  std::string sha256{};         // of the whole file; empty: not computed
};

// Distance volumes that belong together, in the order of the room's lines.
struct DistanceSet {
  std::string origin{};  // DistanceVolume::origin(); different ones joined by " and "
  std::vector<DistanceVolumeRecord> volumes{};  // of the lines that have maps

  bool given() const { return origin == kGivenOrigin; }
};

// What is in use, for reports: the origin of the volumes' maps, or "none".
std::string origin_of(std::span<const DistanceVolume> volumes);

// The volumes of `directory`, one for each line; a line without a file has no maps. Throws Error
// naming the file if one cannot be opened or belongs to another line.
std::vector<DistanceVolume> open_distance_volumes(const std::filesystem::path& directory,
                                                  const Grid& grid);

// The set that such volumes form, without checksums of the files; none if no line has maps.
std::optional<DistanceSet> set_of(std::span<const DistanceVolume> volumes, const Grid& grid);

// Reads every file of the set and sets its checksum. In parallel; throws Error as sha256_of_file,
// and Interrupted.
void add_file_checksums(const std::filesystem::path& directory, DistanceSet* set);

// The set among `recorded` that `found` is, not comparing checksums of files; null if it is none.
const DistanceSet* recorded_as(std::span<const DistanceSet> recorded, const DistanceSet& found);

// The first difference between the volumes in `directory` and the recorded set most like them, as a
// sentence without a full stop; none if they are a recorded set. With nothing recorded there may be
// no volumes.
std::optional<std::string> difference_from_record(std::span<const DistanceSet> recorded,
                                                  const std::optional<DistanceSet>& found,
                                                  const std::filesystem::path& directory);

}  // namespace raywalk
