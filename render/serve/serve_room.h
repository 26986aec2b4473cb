// The work of `raywalk-render serve`.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "core/room/room.h"

namespace raywalk::render {

inline constexpr int kDefaultPort = 8360;

struct ServeOptions {
  std::filesystem::path
      exported{};  // folder made by export-web; empty: made for the time of serving
  std::string host = "127.0.0.1";
  int port = kDefaultPort;  // 0: any free one
};

// Exports the room to a folder that does not exist yet.
using RoomExporter = std::function<void(const std::filesystem::path& folder)>;

// Serves a room until `stopped` returns true, which is polled. Prints the address on a line of its
// own when it can be opened, with the token where it is needed. What was exported for it is
// removed, also after errors. Throws Error where the address cannot be listened on (before
// exporting), and as the exporter and ServedFiles do.
void serve_room(const Room& room, const ServeOptions& options, const RoomExporter& export_room,
                const std::function<bool()>& stopped);

}  // namespace raywalk::render
