#include "core/room/room_fingerprint.h"

#include "core/files/fingerprint.h"

namespace raywalk {

namespace fs = std::filesystem;

std::string room_fingerprint(const Room& room) {
  RoomManifest manifest = room.manifest();
  manifest.distances.reset();  // the files in use are compared instead
  std::string text = manifest_to_json(manifest);
  for (const Line& line : room.grid().lines) {
    const fs::path file = distance_volume_path(room.directory(), line.id);
    if (!fs::exists(file)) continue;
    text += line.id + " " + stamp_of(file).text() + "\n";
  }
  return sha256_hex(text);
}

}  // namespace raywalk
