#include "build_lf/require/floor_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "core/report/markup.h"

namespace raywalk {
namespace {

constexpr double kEyeLevelDeg = 20.0;
constexpr int kMostMaps = 24;
constexpr int kColumnsPerMap = 360;
constexpr double kBorder_px = 26.0;
constexpr double kLongest_px = 520.0;  // of the plan's sides
constexpr double kCaption_px = 20.0;
// Far surfaces seen through a door or a window would shrink the room to a dot.
constexpr double kMostExtents = 4.0;

constexpr const char* kStyle = R"(<style>
.raywalk-plan { --ink: #1f2933; --soft: #6b7785; --surface: #8a97a5; --needed: #d55e00; }
@media (prefers-color-scheme: dark) {
.raywalk-plan { --ink: #e4e8ec; --soft: #98a3af; --surface: #7d8995; --needed: #f08a4b; } }
.raywalk-plan text { font: 12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; fill: var(--soft); }
.raywalk-plan .surface { fill: var(--surface); fill-opacity: .55; }
.raywalk-plan .needed { fill: var(--needed); }
.raywalk-plan .spare { fill: none; stroke: var(--soft); stroke-opacity: .55; stroke-width: .8; }
.raywalk-plan .scale { stroke: var(--ink); stroke-width: 2; }
</style>
)";

std::vector<PlanPoint> surface_points(const Room& room) {
  std::vector<std::pair<int, int>> maps;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    for (int map = 0; map < room.distances(line).maps(); ++map) maps.emplace_back(line, map);
  }
  std::vector<PlanPoint> points;
  const size_t count = std::min<size_t>(kMostMaps, maps.size());
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
        if (confidence == 0 || !std::isfinite(metres)) continue;
        const Eigen::Vector3d point = from + metres * direction_from_angles(angles);
        points.push_back({point.x(), point.z()});
      }
    }
  }
  return points;
}

struct Bounds {
  PlanPoint min{INFINITY, INFINITY}, max{-INFINITY, -INFINITY};
  void add(PlanPoint point) {
    min = {std::min(min.x_m, point.x_m), std::min(min.z_m, point.z_m)};
    max = {std::max(max.x_m, point.x_m), std::max(max.z_m, point.z_m)};
  }
};

Bounds station_bounds(const Grid& grid) {
  Bounds bounds;
  for (const Line& line : grid.lines) {
    for (const Station& s : line.stations) bounds.add({s.position_m.x(), s.position_m.z()});
  }
  return bounds;
}

// Around the stations and the surfaces near them.
Bounds plan_bounds(const Grid& grid, std::vector<PlanPoint>* surfaces) {
  Bounds bounds = station_bounds(grid);
  const double extent_m =
      std::max(bounds.max.x_m - bounds.min.x_m, bounds.max.z_m - bounds.min.z_m);
  const double middle_x = 0.5 * (bounds.min.x_m + bounds.max.x_m);
  const double middle_z = 0.5 * (bounds.min.z_m + bounds.max.z_m);
  std::erase_if(*surfaces, [&](PlanPoint p) {
    const double off_m = std::max(std::abs(p.x_m - middle_x), std::abs(p.z_m - middle_z));
    return off_m > kMostExtents * extent_m;
  });
  for (const PlanPoint& point : *surfaces) bounds.add(point);
  return bounds;
}

double round_length(double about_m) {
  const double power = std::pow(10.0, std::floor(std::log10(about_m)));
  return about_m >= 5.0 * power ? 5.0 * power : about_m >= 2.0 * power ? 2.0 * power : power;
}

}  // namespace

std::string floor_plan_svg(const Room& room, const KeptStations& kept) {
  std::vector<PlanPoint> surfaces = surface_points(room);
  const Bounds bounds = plan_bounds(room.grid(), &surfaces);
  const double width_m = bounds.max.x_m - bounds.min.x_m;
  const double depth_m = bounds.max.z_m - bounds.min.z_m;
  const double scale = kLongest_px / std::max(width_m, depth_m);
  const double width_px = 2.0 * kBorder_px + std::max(scale * width_m, 0.5 * kLongest_px);
  const double height_px = 2.0 * kBorder_px + scale * depth_m + kCaption_px;
  const auto dot = [&](const char* css_class, PlanPoint p, double radius_px) {
    return fmt::format("<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", css_class,
                       plain_number(kBorder_px + scale * (p.x_m - bounds.min.x_m), 1),
                       plain_number(kBorder_px + scale * (bounds.max.z_m - p.z_m), 1),
                       plain_number(radius_px, 1));
  };
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"raywalk-plan\" role=\"img\" "
      "width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "style=\"max-width: 100%; height: auto\">\n<title>The room from above</title>\n{2}",
      width_px, height_px, kStyle);
  // Neighbouring maps place the same surfaces: a point per pixel of the drawing is enough.
  std::set<std::pair<int, int>> drawn;
  for (const PlanPoint& point : surfaces) {
    const auto cell =
        std::pair(static_cast<int>(scale * point.x_m), static_cast<int>(scale * point.z_m));
    if (drawn.insert(cell).second) svg += dot("surface", point, 1.1);
  }
  for (size_t i = 0; i < room.grid().lines.size(); ++i) {
    const std::vector<Station>& stations = room.grid().lines[i].stations;
    for (size_t s = 0; s < stations.size(); ++s) {
      const bool needed = std::ranges::binary_search(kept[i], static_cast<int>(s));
      const PlanPoint place{stations[s].position_m.x(), stations[s].position_m.z()};
      svg += needed ? dot("needed", place, 3.6) : dot("spare", place, 1.8);
    }
  }
  const double bar_m = round_length(0.25 * kLongest_px / scale);
  svg += fmt::format(
      "<line class=\"scale\" x1=\"{0}\" y1=\"{1:.0f}\" x2=\"{2}\" y2=\"{1:.0f}\"/>\n"
      "<text x=\"{3}\" y=\"{4:.0f}\">{5} m; front (+z) is up</text>\n",
      plain_number(kBorder_px, 1), height_px - 12.0, plain_number(kBorder_px + scale * bar_m, 1),
      plain_number(kBorder_px + scale * bar_m + 8.0, 1), height_px - 8.0, plain_number(bar_m, 3));
  return svg + "</svg>\n";
}

}  // namespace raywalk
