#include "core/view/view_height.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <ranges>
#include <span>
#include <vector>

#include "core/geometry/line_gaps.h"

namespace raywalk {
namespace {

constexpr double kReachInSpacings = 4.0;

// The stations that count, at least one: farther ones inside a long gap.
double reach_at(const Line& line, double along_m) {
  const auto after = std::ranges::lower_bound(line.stations, along_m, {}, &Station::along_m);
  double nearest_m = std::numeric_limits<double>::infinity();
  if (after != line.stations.end()) nearest_m = after->along_m - along_m;
  if (after != line.stations.begin()) {
    nearest_m = std::min(nearest_m, along_m - std::prev(after)->along_m);
  }
  return std::max(kReachInSpacings * covering_spacing(line), 2.0 * nearest_m);
}

}  // namespace

// Local linear regression with tricube weights: W. S. Cleveland, "Robust locally weighted
// regression and smoothing scatterplots", 1979.
double height_along(const Line& line, double along_m) {
  const double at_m = std::clamp(along_m, line.first_m(), line.last_m());
  const double reach_m = reach_at(line, at_m);
  double sum = 0.0, sum_x = 0.0, sum_y = 0.0, sum_xx = 0.0, sum_xy = 0.0;
  const std::span within(
      std::ranges::lower_bound(line.stations, at_m - reach_m, {}, &Station::along_m),
      std::ranges::upper_bound(line.stations, at_m + reach_m, {}, &Station::along_m));
  for (const Station& station : within) {
    const double x = (station.along_m - at_m) / reach_m;
    if (std::abs(x) >= 1.0) continue;
    const double y = station.position_m.y() - line.height_m;
    const double weight = std::pow(1.0 - std::pow(std::abs(x), 3), 3);
    sum += weight;
    sum_x += weight * x;
    sum_y += weight * y;
    sum_xx += weight * x * x;
    sum_xy += weight * x * y;
  }
  const double determinant = sum * sum_xx - sum_x * sum_x;
  constexpr double kOneStation = 1e-12;  // then there is no slope
  const double above = determinant > kOneStation * sum * sum
                           ? (sum_xx * sum_y - sum_x * sum_xy) / determinant
                           : sum_y / sum;
  return line.height_m + above;
}

double height_around(const Grid& grid, PlanPoint viewpoint) {
  if (const auto cell = find_cell(grid, viewpoint)) {
    return height_in_cell(grid, grid.cells[static_cast<size_t>(*cell)], viewpoint);
  }
  std::vector<int> lines(grid.lines.size());
  std::iota(lines.begin(), lines.end(), 0);
  return height_beside(grid, lines, viewpoint);
}

double height_in_cell(const Grid& grid, const Cell& cell, PlanPoint viewpoint) {
  const auto side = [&](Side which) {
    const Line& line = grid.lines[static_cast<size_t>(cell.line[static_cast<size_t>(which)])];
    return height_along(line, along_line(line, viewpoint));
  };
  const double right = (viewpoint.x_m - cell.x_min_m) / (cell.x_max_m - cell.x_min_m);
  const double front = (viewpoint.z_m - cell.z_min_m) / (cell.z_max_m - cell.z_min_m);
  return 0.5 * (std::lerp(side(Side::kLeft), side(Side::kRight), right) +
                std::lerp(side(Side::kBack), side(Side::kFront), front));
}

double height_beside(const Grid& grid, std::span<const int> lines, PlanPoint viewpoint) {
  double sum_m = 0.0;
  for (const int index : lines) {
    const Line& line = grid.lines[static_cast<size_t>(index)];
    sum_m += height_along(line, along_line(line, viewpoint));
  }
  return sum_m / static_cast<double>(lines.size());
}

}  // namespace raywalk
