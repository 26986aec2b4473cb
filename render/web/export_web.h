// Writes a room as a folder that a browser shows: pictures and distances of its stations, a
// manifest and the viewer's page, all static files with relative paths.
//
//   index.html, viewer.js, viewer.css  the page
//   manifest.json                      everything else that the page needs to know (web_manifest.h)
//   stations/0000.jpg                  a station's panorama, complete (station_pictures.h)
//   stations/0000-coarse.jpg           the same, small, shown while the other is loading
//   stations/0000.inverse                the distances seen from it (inverse_file.h)
//   truth/000.jpg, 000-engine.jpg      only with WebExportOptions::truth
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "core/room/room.h"
#include "core/view/view_options.h"

namespace raywalk::render {

// How well stations that an export leaves out are re-created from those that it holds.
struct WebQuality {
  double psnr_db = 0.0;  // mean over the views
  double worst_psnr_db = 0.0;
  int views = 0;       // stations re-created
  std::string text{};  // the same in one sentence, for users
};

// Measures that for the stations `kept` of a room, in views of `options`, as wide as the export;
// none where nothing is left out. A function, as what makes views knows nothing of what judges
// them.
using MeasureQuality = std::function<std::optional<WebQuality>(
    const Room& room, const KeptStations& kept, const ViewOptions& options)>;

struct WebExportOptions {
  double budget_mb = 256.0;       // 10^6 bytes of GPU memory that the page may use; > 0
  int width_px = 0;               // of the panoramas, at most; 0: what the scene requires
  std::optional<double> k_deg{};  // of the connection, in [45, 90]; none: the default
  std::string title{};
  std::optional<PlanPoint> start{};  // metres; none: the middle of the grid's middle cell
  std::filesystem::path hotspots{};  // JSON (hotspots.h); empty: none
  std::filesystem::path path{};      // CSV of views as `raywalk-render path` reads; empty: none
  std::filesystem::path truth{};     // CSV of true panoramas, file,x,y,z; empty: none
  std::filesystem::path page{};      // folder of the built page; empty: viewer_page()
  MeasureQuality measure_quality{};  // empty: the quality is not stated
};

// Writes the folder `out`, which appears only when it is complete. With `replace`, an earlier
// export is replaced then. Returns lines for the user: what was chosen and why, and the sizes.
// Throws UsageError for options out of range, Error for a budget that no width fits, for files that
// cannot be read and as OutputFolder does, Interrupted.
std::string export_web(const Room& room, const WebExportOptions& options,
                       const std::filesystem::path& out, bool replace);

// Where the built page is installed: share/raywalk/viewer beside the folder of the program.
std::filesystem::path viewer_page();

}  // namespace raywalk::render
