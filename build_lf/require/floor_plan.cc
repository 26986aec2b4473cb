#include "build_lf/require/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "core/report/plan_drawing.h"

namespace raywalk::build_lf {
namespace {

constexpr double kEyeLevelDeg = 20.0;
constexpr int kMaxDrawnMaps = 24;
constexpr int kColumnsPerMap = 360;
constexpr double kBorder_px = 26.0;
// Limits the plot, as surfaces far away behind a door or window would shrink the room to a dot.
constexpr double kMaxExtents = 4.0;

constexpr std::string_view kRules = R"(.raywalk-plan .surface { fill: #828e9b; fill-opacity: .55; }
.raywalk-plan .needed { fill: var(--accent); }
.raywalk-plan .spare { fill: none; stroke: var(--soft); stroke-opacity: .55; stroke-width: .8; }
)";

std::vector<PlanPoint> surface_points(const Room& room) {
  std::vector<std::pair<int, int>> maps;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    for (int map = 0; map < room.distances(line).maps(); ++map) maps.emplace_back(line, map);
  }
  std::vector<PlanPoint> points;
  const size_t count = std::min<size_t>(kMaxDrawnMaps, maps.size());
  for (size_t i = 0; i < count; ++i) {
    const auto [line, map] = maps[i * maps.size() / count];
    const DistanceVolume& volume = room.distances(line);
    const PanoramaSize size = volume.size();
    const auto station = static_cast<size_t>(volume.stations()[static_cast<size_t>(map)]);
    const Eigen::Vector3d& from =
        room.grid().lines[static_cast<size_t>(line)].stations[station].position_m;
    const int column_step = std::max(1, size.width / kColumnsPerMap);
    const int row_step = std::max(1, size.height / 18);
    for (int theta = 0; theta < size.width; theta += column_step) {
      for (int row = row_step / 2; row < size.height; row += row_step) {
        const SphereAngles angles =
            angles_from_pixel({static_cast<double>(theta), static_cast<double>(row)}, size);
        if (std::abs(degrees_from_radians(angles.phi_rad)) > kEyeLevelDeg) continue;
        const float metres = volume.distance_column(map, theta)[static_cast<size_t>(row)];
        const auto confidence = volume.confidence_column(map, theta)[static_cast<size_t>(row)];
        if (confidence == 0 || !(metres > 0.0f) || !std::isfinite(metres)) continue;
        const Eigen::Vector3d point = from + metres * direction_from_angles(angles);
        points.push_back({point.x(), point.z()});
      }
    }
  }
  return points;
}

PlanBounds station_bounds(const Grid& grid) {
  PlanBounds bounds;
  for (const Line& line : grid.lines) {
    for (const Station& s : line.stations) bounds.add({s.position_m.x(), s.position_m.z()});
  }
  return bounds;
}

// Bounds of the stations and the surfaces near them.
PlanBounds plan_bounds(const Grid& grid, std::vector<PlanPoint>* surfaces) {
  PlanBounds bounds = station_bounds(grid);
  const double extent_m = std::max(bounds.width_m(), bounds.depth_m());
  const double middle_x = 0.5 * (bounds.min.x_m + bounds.max.x_m);
  const double middle_z = 0.5 * (bounds.min.z_m + bounds.max.z_m);
  std::erase_if(*surfaces, [&](PlanPoint p) {
    const double off_m = std::max(std::abs(p.x_m - middle_x), std::abs(p.z_m - middle_z));
    return off_m > kMaxExtents * extent_m;
  });
  for (const PlanPoint& point : *surfaces) bounds.add(point);
  return bounds;
}

}  // namespace

std::string floor_plan_svg(const Room& room, const KeptStations& kept) {
  std::vector<PlanPoint> surfaces = surface_points(room);
  PlanDrawing drawing(plan_bounds(room.grid(), &surfaces), kBorder_px);
  // Neighbouring maps place the same surfaces: one point per pixel of the drawing is enough.
  const double pixel_m = drawing.metres_of(1.0);
  std::set<std::pair<int, int>> drawn;
  for (const PlanPoint& point : surfaces) {
    const auto cell =
        std::pair(static_cast<int>(point.x_m / pixel_m), static_cast<int>(point.z_m / pixel_m));
    if (drawn.insert(cell).second) drawing.add_dot("surface", point, 1.1);
  }
  for (size_t i = 0; i < room.grid().lines.size(); ++i) {
    const std::vector<Station>& stations = room.grid().lines[i].stations;
    for (size_t s = 0; s < stations.size(); ++s) {
      const bool needed = std::ranges::binary_search(kept[i], static_cast<int>(s));
      const PlanPoint place{stations[s].position_m.x(), stations[s].position_m.z()};
      drawing.add_dot(needed ? "needed" : "spare", place, needed ? 3.6 : 1.8);
    }
  }
  return drawing.svg("The room from above", kRules);
}

}  // namespace raywalk::build_lf
