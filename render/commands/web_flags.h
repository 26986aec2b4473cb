// Options of the commands that write a room for browsers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "render/web/export_web.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace raywalk::render {

struct WebFlags {
  WebExportOptions options{};
  std::string start{};    // "X,Z"; empty: not given
  double k_deg = 0.0;     // 0: not given
  bool captured = false;  // the photographs, also where the room is refined
};

// --captured, and what only an export needs: --budget-mb, --width, --k, --title, --start,
// --hotspots, --path and --truth, which are returned.
// `flags` has to outlive the command.
std::vector<CLI::Option*> add_web_flags(CLI::App* command, WebFlags* flags);

// What they ask for of the room in a directory; its name is the title. Throws UsageError for a
// start that is not a point.
WebExportOptions web_options(const std::filesystem::path& room, const WebFlags& flags);

// The room to show: what was developed from that of the directory (core/room/refined_record.h), or
// itself.
Room web_room(const std::filesystem::path& room, const WebFlags& flags);

}  // namespace raywalk::render
