#include "core/room/room.h"

#include <algorithm>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// A manifest takes some 150 bytes per station; this is room for 400,000 of them.
constexpr std::size_t kMaxManifestBytes = std::size_t{64} << 20;

}  // namespace

fs::path manifest_path(const fs::path& room) { return room / "manifest.json"; }

fs::path line_volume_path(const fs::path& room, const std::string& line_id) {
  return room / "lines" / (line_id + ".h5");
}

fs::path distance_volume_path(const fs::path& room, const std::string& line_id) {
  return room / "distances" / (line_id + ".h5");
}

Room Room::open(const fs::path& directory) {
  std::error_code error;
  if (!fs::is_directory(directory, error)) {
    throw Error(directory.string() + ": no such room; `raywalk-build-lf pack` makes one");
  }
  const fs::path manifest = manifest_path(directory);
  if (!fs::exists(manifest, error)) {
    throw Error(directory.string() + ": not a room: it has no manifest.json");
  }
  Room room;
  room.directory_ = directory;
  room.manifest_ = manifest_from_json(read_file(manifest, kMaxManifestBytes), manifest.string());
  for (const Line& line : room.grid().lines) {
    const int stations = static_cast<int>(line.stations.size());
    room.volumes_.push_back(
        LineVolume::open(line_volume_path(directory, line.id), stations, room.panorama()));
    const fs::path distances = distance_volume_path(directory, line.id);
    room.distances_.push_back(fs::exists(distances, error)
                                  ? DistanceVolume::open(distances, stations)
                                  : DistanceVolume());
  }
  return room;
}

bool Room::has_distances() const {
  return std::any_of(distances_.begin(), distances_.end(),
                     [](const DistanceVolume& volume) { return volume.maps() > 0; });
}

bool Room::masked() const {
  return std::any_of(volumes_.begin(), volumes_.end(),
                     [](const LineVolume& volume) { return volume.masked(); });
}

}  // namespace raywalk
