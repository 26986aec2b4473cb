// Writes a room as a folder that a browser shows: pictures and distances of its stations, a
// manifest and the viewer's page, all static files with relative paths.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/room/room.h"

namespace raywalk::render {

struct WebExportOptions {
  double budget_mb = 256.0;          // 10^6 bytes of GPU memory that the page may use; > 0
  int width_px = 0;                  // of the panoramas, at most; 0: what the scene requires
  std::optional<double> k_deg{};     // of the connection, in [45, 90]; none: the room's (choose_k)
  std::string title{};               // empty: the room's name
  std::optional<PlanPoint> start{};  // metres; none: the middle of the grid's middle cell
  std::filesystem::path hotspots{};  // JSON, see hotspots.h; empty: none
  std::filesystem::path path{};      // CSV of views as `raywalk-render path` reads; empty: none
  std::filesystem::path truth{};     // CSV of true panoramas, file,x,y,z; empty: none
  std::filesystem::path page{};      // folder of the built page; empty: viewer_page()
};

// Writes the folder `out`, which appears only when it is complete. With `replace`, an earlier
// export is replaced then. Returns lines for the user: what was chosen and why, and the sizes.
// Throws UsageError for options out of range, Error for a budget that no width fits, for files that
// cannot be read and as require_replaceable() does, Interrupted.
std::string export_web(const Room& room, const WebExportOptions& options,
                       const std::filesystem::path& out, bool replace);

// Where the built page is installed: share/raywalk/viewer beside the folder of the program.
std::filesystem::path viewer_page();

}  // namespace raywalk::render
