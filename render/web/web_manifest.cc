#include "render/web/web_manifest.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "core/geometry/line_gaps.h"
#include "core/view/distance_view.h"

namespace raywalk::render {
namespace {

using nlohmann::ordered_json;

ordered_json lines_json(const Grid& grid) {
  ordered_json lines = ordered_json::array();
  int index = 0;
  for (const Line& line : grid.lines) {
    ordered_json stations = ordered_json::array();
    for (const Station& station : line.stations) {
      const Eigen::Vector3d& at_m = station.position_m;
      stations.push_back({{"name", station_name(index++)},
                          {"along_m", station.along_m},
                          {"position_m", {at_m.x(), at_m.y(), at_m.z()}}});
    }
    lines.push_back({{"id", line.id},
                     {"origin_m", {line.origin.x_m, line.origin.z_m}},
                     {"direction", {line.direction.x_m, line.direction.z_m}},
                     {"height_m", line.height_m},
                     {"spacing_m", covering_spacing(line)},
                     {"stations", std::move(stations)}});
  }
  return lines;
}

ordered_json cells_json(const Grid& grid) {
  ordered_json cells = ordered_json::array();
  for (const Cell& cell : grid.cells) {
    cells.push_back({{"x_min_m", cell.x_min_m},
                     {"x_max_m", cell.x_max_m},
                     {"z_min_m", cell.z_min_m},
                     {"z_max_m", cell.z_max_m},
                     {"lines", cell.line}});
  }
  return cells;
}

ordered_json quality_json(const std::optional<WebQuality>& quality) {
  if (!quality) return nullptr;
  return {{"psnr_db", quality->psnr_db},
          {"worst_psnr_db", quality->worst_psnr_db},
          {"views", quality->views},
          {"text", quality->text}};
}

ordered_json truths_json(const std::vector<TruthPair>& truths) {
  ordered_json list = ordered_json::array();
  for (const TruthPair& truth : truths) {
    list.push_back({{"x_m", truth.position_m.x()},
                    {"y_m", truth.position_m.y()},
                    {"z_m", truth.position_m.z()},
                    {"picture", truth.picture},
                    {"engine", truth.engine}});
  }
  return list;
}

ordered_json hotspots_json(const std::vector<Hotspot>& hotspots) {
  ordered_json list = ordered_json::array();
  for (const Hotspot& hotspot : hotspots) {
    ordered_json entry{{"x_m", hotspot.position_m.x()},
                       {"y_m", hotspot.position_m.y()},
                       {"z_m", hotspot.position_m.z()},
                       {"text", hotspot.text}};
    if (!hotspot.link.empty()) entry["link"] = hotspot.link;
    list.push_back(std::move(entry));
  }
  return list;
}

ordered_json path_json(const std::vector<PathView>& path) {
  ordered_json list = ordered_json::array();
  for (const PathView& view : path) {
    ordered_json entry{{"x_m", view.viewpoint.plan.x_m},
                       {"z_m", view.viewpoint.plan.z_m},
                       {"yaw_deg", view.yaw_deg},
                       {"pitch_deg", view.pitch_deg},
                       {"roll_deg", view.roll_deg}};
    if (view.viewpoint.height_m) entry["y_m"] = *view.viewpoint.height_m;
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace

std::string station_name(int index) { return fmt::format("{:04}", index); }

ordered_json grid_json(const Grid& grid) {
  return {{"lines", lines_json(grid)}, {"cells", cells_json(grid)}};
}

ordered_json web_manifest(const Room& room, const WebContent& content) {
  ordered_json grid = grid_json(room.grid());
  for (std::size_t line = 0; line < room.grid().lines.size(); ++line) {
    ordered_json& stations = grid["lines"][line]["stations"];
    for (ordered_json& station : stations) station["has_map"] = false;
    for (const int station : room.distances(static_cast<int>(line)).stations()) {
      stations[static_cast<std::size_t>(station)]["has_map"] = true;
    }
  }
  return {{"format", kWebFormat},
          {"version", kWebVersion},
          {"program", "raywalk-render " RAYWALK_VERSION},
          {"title", content.title},
          {"budget_mb", content.budget_mb},
          {"panorama", {{"width_px", content.width}, {"coarse_width_px", content.coarse_width}}},
          {"distances",
           {{"width_px", content.distance_width},
            {"inverse_step_per_m", content.inverse_step_per_m},
            {"surface_tolerance", surface_tolerance_of(content.distance_width)}}},
          {"view",
           {{"method", method_name(content.view.method)},
            {"k_deg", content.view.k_deg},
            {"overlap_deg", content.view.overlap_deg},
            {"distance_maps", content.view.distance_maps}}},
          {"lines", std::move(grid["lines"])},
          {"cells", std::move(grid["cells"])},
          {"start", {{"x_m", content.start.x_m}, {"z_m", content.start.z_m}, {"yaw_deg", 0.0}}},
          {"vertical_range_m", content.vertical_range_m},
          {"quality", quality_json(content.quality)},
          {"truth", truths_json(content.truths)},
          {"hotspots", hotspots_json(content.hotspots)},
          {"path_frames_per_s", kWebPathFps},
          {"path", path_json(content.path)}};
}

}  // namespace raywalk::render
