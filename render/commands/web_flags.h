// Options of the commands that write a room for browsers.
#pragma once

#include <string>
#include <vector>

#include "render/web/export_web.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace raywalk::render {

struct WebFlags {
  WebExportOptions options{};
  std::string start{};  // "X,Z"; empty: not given
  double k_deg = 0.0;   // 0: not given
};

// --budget-mb, --width, --k, --title, --start, --hotspots, --path and --truth; returns them.
// `flags` has to outlive the command.
std::vector<CLI::Option*> add_web_flags(CLI::App* command, WebFlags* flags);

// What they ask for. Throws UsageError for a start that is not a point.
WebExportOptions web_options(const WebFlags& flags);

}  // namespace raywalk::render
