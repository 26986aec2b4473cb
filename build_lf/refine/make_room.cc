#include "build_lf/refine/make_room.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "build_lf/depth/estimate_depth.h"
#include "build_lf/pack/distance_sets.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/refine/refine_room.h"
#include "core/base/escaped.h"
#include "core/files/output_folder.h"
#include "core/room/refined_record.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

bool has_estimated_distances(const fs::path& room) {
  return std::ranges::any_of(find_distances(room, read_manifest(room)), [](const auto& found) {
    return found.kind == DistanceKind::kEstimated && found.fault.empty();
  });
}

// In the middle of a cell, or of the first line.
PlanPoint place_of_a_view(const Grid& grid) {
  if (!grid.cells.empty()) {
    const Cell& cell = grid.cells.front();
    return {0.5 * (cell.x_min_m + cell.x_max_m), 0.5 * (cell.z_min_m + cell.z_max_m)};
  }
  const std::vector<Station>& stations = grid.lines.front().stations;
  const auto& middle_m = stations[stations.size() / 2].position_m;
  return {middle_m[0], middle_m[2]};
}

}  // namespace

std::string make_room(const PackOptions& options) {
  const fs::path room = without_trailing_slash(options.out);
  if (fs::exists(manifest_path(room)) && is_packed_from(room, plan_pack(options))) {
    spdlog::info("{}: packed before", room.string());
  } else {
    pack_room(options);
  }
  if (has_estimated_distances(room)) {
    spdlog::info("{}: distances estimated before", room.string());
  } else {
    const DepthSummary summary = estimate_depth({.room = room});
    require_usable(summary);
    std::istringstream lines(text_of(summary));
    for (std::string line; std::getline(lines, line);) spdlog::info("{}", line);
  }
  const fs::path refined = refined_room_path(room);
  if (current_refined_room(Room::open(room))) {
    spdlog::info("{}: refined before", refined.string());
  } else {
    refine_room({.room = room, .out = refined, .form = options.form, .replace = options.replace});
  }
  const Room made = Room::open(refined);
  const PlanPoint at = place_of_a_view(made.grid());
  return fmt::format("{}\nnext: raywalk-render view {} --at {:g},{:g}",
                     summary_of(info_of(made), escaped(refined.string())),
                     escaped(shell_word(refined.string())), at.x_m, at.z_m);
}

}  // namespace raywalk::build_lf
