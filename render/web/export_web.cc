#include "render/web/export_web.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/output_folder.h"
#include "core/files/shipped_configs.h"
#include "core/room/requirements.h"
#include "core/view/view_plan.h"
#include "render/view/path_curve.h"
#include "render/view/path_table.h"
#include "render/view/presets.h"
#include "render/web/hotspots.h"
#include "render/web/station_files.h"
#include "render/web/truth_pairs.h"
#include "render/web/vertical_range.h"
#include "render/web/web_manifest.h"
#include "render/web/web_plan.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastAskedWidth = 64;
constexpr const char* kStations = "stations";

bool is_part_of_export(const fs::path& relative, bool is_folder) {
  constexpr std::array kFolders{kStations, "truth"};
  // Of the page's files and of those of the stations and truths.
  constexpr std::array kPageExtensions{".html", ".js", ".css", ".map", ".txt"};
  constexpr std::array kDataExtensions{".jpg", ".inverse"};
  const auto is_one_of = [](const auto& names, const fs::path& name) {
    return std::ranges::find(names, name) != names.end();
  };
  if (is_folder) return is_one_of(kFolders, relative);
  if (relative.has_parent_path()) {
    return is_one_of(kFolders, relative.parent_path()) &&
           is_one_of(kDataExtensions, relative.extension());
  }
  return relative == kManifestName || is_one_of(kPageExtensions, relative.extension());
}

void require_options(const WebExportOptions& options) {
  if (!(options.budget_mb > 0.0) || !std::isfinite(options.budget_mb)) {
    throw UsageError(fmt::format("--budget-mb is {:g}; it must be above 0", options.budget_mb));
  }
  if (options.width_px != 0 && options.width_px < kLeastAskedWidth) {
    throw UsageError(fmt::format("--width is {}; it must be at least {} pixels", options.width_px,
                                 kLeastAskedWidth));
  }
  if (options.k_deg && !(*options.k_deg >= 45.0 && *options.k_deg <= 90.0)) {
    throw UsageError(fmt::format("--k is {:g}; it must be in 45 to 90 degrees", *options.k_deg));
  }
}

fs::path page_of(const WebExportOptions& options) {
  fs::path page = options.page.empty() ? viewer_page() : options.page;
  if (!fs::exists(page / "index.html")) {
    throw Error(
        fmt::format("the viewer's page is not installed ({} is missing): build Raywalk "
                    "with Node.js, see docs/viewer.md",
                    (page / "index.html").string()));
  }
  return page;
}

void copy_page(const fs::path& page, const fs::path& folder) {
  for (const fs::directory_entry& entry : fs::directory_iterator(page)) {
    if (!entry.is_regular_file()) continue;
    write_file_atomically(folder / entry.path().filename(), read_file(entry.path()));
  }
}

// How views of the room are rendered.
ViewOptions view_options(const Room& room, const WebExportOptions& options) {
  ViewOptions view = default_options();
  view.method = room.has_distances() ? ViewMethod::kTwoSided : ViewMethod::kInitial;
  if (options.k_deg) view.k_deg = *options.k_deg;
  return view;
}

ConnectionRule rule_of(const ViewOptions& view) {
  return {radians_from_degrees(view.k_deg), radians_from_degrees(view.overlap_deg)};
}

PlanPoint centre_of(const Cell& cell) {
  return {0.5 * (cell.x_min_m + cell.x_max_m), 0.5 * (cell.z_min_m + cell.z_max_m)};
}

// The middle of the cell nearest to the middle of all, or of the middle line.
PlanPoint middle_of(const Grid& grid) {
  if (grid.cells.empty()) {
    const Line& line = grid.lines[grid.lines.size() / 2];
    const double along_m = 0.5 * (line.first_m() + line.last_m());
    return {line.origin.x_m + along_m * line.direction.x_m,
            line.origin.z_m + along_m * line.direction.z_m};
  }
  PlanPoint mean{};
  for (const Cell& cell : grid.cells) {
    mean.x_m += centre_of(cell).x_m / static_cast<double>(grid.cells.size());
    mean.z_m += centre_of(cell).z_m / static_cast<double>(grid.cells.size());
  }
  const auto off_m = [&](const Cell& cell) {
    return std::hypot(centre_of(cell).x_m - mean.x_m, centre_of(cell).z_m - mean.z_m);
  };
  return centre_of(*std::ranges::min_element(grid.cells, {}, off_m));
}

PlanPoint start_of(const Grid& grid, const ConnectionRule& rule, const WebExportOptions& options) {
  if (!options.start) return middle_of(grid);
  try {
    const ViewPlan plan(grid, *options.start, rule);
  } catch (const Error& e) {
    throw Error(
        fmt::format("--start {:g},{:g}: {}", options.start->x_m, options.start->z_m, e.what()));
  }
  return *options.start;
}

// The walk through the places of the table. The page keeps it inside the cells where it swings out.
std::vector<PathView> walk_of(const Room& room, const ConnectionRule& rule,
                              const WebExportOptions& options) {
  if (options.path.empty()) return {};
  const std::vector<PathView> places = read_path(options.path);
  require_inside(room, rule, options.path, places);
  if (PathCurve(places, Pace::kConstant).length() == 0.0) {
    throw Error(options.path.string() + ": all views are the same; a walk needs two places");
  }
  return frames_of(places, {.fps = kWebPathFps}, options.path);
}

std::string quality_line(const WebContent& content, const WebPlan& plan) {
  if (content.quality) return content.quality->text;
  return plan.stations == plan.captured_stations ? "all stations are exported" : "not measured";
}

}  // namespace

std::string export_web(const Room& room, const WebExportOptions& options, const fs::path& out,
                       bool replace) {
  require_options(options);
  const fs::path page = page_of(options);
  WebContent content{
      .title = options.title, .budget_mb = options.budget_mb, .view = view_options(room, options)};
  warn_without_distances(room);
  const ConnectionRule rule = rule_of(content.view);
  content.start = start_of(room.grid(), rule, options);
  content.path = walk_of(room, rule, options);
  if (!options.hotspots.empty()) content.hotspots = read_hotspots(options.hotspots);
  const WebPlan plan =
      plan_export(room, current_requirements(room), {options.budget_mb, options.width_px, rule});
  content.width = content.view.width = plan.width;
  content.coarse_width = coarse_width_of(plan.width);
  content.distance_width = plan.distance_width;

  OutputFolder folder(
      out, replace,
      {"an exported room", kManifestName, fmt::format("\"{}\"", kWebFormat), is_part_of_export});
  make_directories(folder.directory() / kStations);
  const Room part = room.subset(plan.kept);
  content.inverse_step_per_m =
      write_stations(part, content.view, plan.distance_width, folder.directory() / kStations);
  if (!options.truth.empty()) {
    content.truths = write_truth_pairs(room, content.view, options.truth, folder.directory());
  }
  content.vertical_range_m = vertical_range_m(part, content.view.distance_maps);
  if (options.measure_quality) {
    content.quality = options.measure_quality(room, plan.kept, content.view);
  }
  copy_page(page, folder.directory());
  write_file_atomically(folder.directory() / kManifestName, json_text(web_manifest(part, content)));
  folder.complete();
  return fmt::format(
      "{}:\n{}  eye height {:.2f} m up and down\n  quality    {}\n  files      {:.1f} MB",
      escaped(out.string()), plan.summary, content.vertical_range_m, quality_line(content, plan),
      1e-6 * static_cast<double>(bytes_in(out)));
}

fs::path viewer_page() {
  return (program_folder() / ".." / "share" / "raywalk" / "viewer").lexically_normal();
}

}  // namespace raywalk::render
