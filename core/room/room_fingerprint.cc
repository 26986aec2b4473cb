#include "core/room/room_fingerprint.h"

#include <fmt/format.h>

#include "core/files/fingerprint.h"
#include "core/room/hdf5_file.h"

namespace raywalk {

std::string distances_sha256(const Room& room) {
  std::string text;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const DistanceVolume& volume = room.distances(line);
    if (volume.maps() == 0) continue;
    const Line& of_line = room.grid().lines[static_cast<std::size_t>(line)];
    text += of_line.id;
    for (const int station : volume.stations()) {
      const Eigen::Vector3d& p = of_line.stations[static_cast<std::size_t>(station)].position_m;
      text += fmt::format(" {},{},{}", p.x(), p.y(), p.z());
    }
    text += " " + volume.header_sha256() + "\n";
  }
  return sha256_hex(text);
}

std::string room_fingerprint(const Room& room) {
  RoomManifest manifest = room.manifest();
  manifest.distances = DistanceKind::kNone;  // those in use are compared instead
  std::string text = manifest_to_json(manifest) + distances_sha256(room);
  if (!room.gains().empty()) {
    text += Hdf5File::open(gains_path(room.directory())).text_attribute("sha256").value_or("");
  }
  return sha256_hex(text);
}

}  // namespace raywalk
