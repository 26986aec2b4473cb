#include "core/room/room_fingerprint.h"

#include <fmt/format.h>

#include <span>

#include "core/files/sha256.h"

namespace raywalk {

namespace fs = std::filesystem;

std::string room_fingerprint(const Room& room) {
  std::string text = manifest_to_json(room.manifest());
  for (const Line& line : room.grid().lines) {
    const fs::path file = distance_volume_path(room.directory(), line.id);
    if (!fs::exists(file)) continue;
    text += fmt::format("{} {} {}\n", line.id, fs::file_size(file),
                        fs::last_write_time(file).time_since_epoch().count());
  }
  return sha256_hex(std::as_bytes(std::span(text)));
}

}  // namespace raywalk
