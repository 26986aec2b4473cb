#include "core/geometry/grid.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/geometry/crossing_stations.h"
#include "core/geometry/line_search.h"

namespace raywalk {
namespace {

// A side of a cell is captured if no gap between its stations exceeds this multiple of the line's
// median spacing: a few lost frames do not open a cell, a missing section does.
constexpr double kLargestGapInSpacings = 4.0;

Eigen::Vector2d vector_of(PlanPoint point) { return {point.x_m, point.z_m}; }
PlanPoint point_of(const Eigen::Vector2d& vector) { return {vector.x(), vector.y()}; }

void check_finite(std::span<const StationPose> stations) {
  for (const StationPose& station : stations) {
    if (!station.position_m.allFinite()) {
      throw Error(fmt::format("{}: the position is not finite", name_of(station)));
    }
  }
}

double tolerance_for(std::span<const StationPose> stations, const GridTolerance& tolerance) {
  if (tolerance.off_line_m) return *tolerance.off_line_m;
  Eigen::AlignedBox3d extent;
  for (const StationPose& station : stations) extent.extend(station.position_m);
  return std::max(0.1 * median_nearest_distance(stations), 1e-9 * extent.diagonal().norm());
}

// A slider may climb slightly along its travel, so a station's height is compared with the straight
// line through all heights, y = mean + slope (along - mean along).
void check_heights(const Line& line, std::span<const StationPose> stations,
                   const std::vector<int>& members, double tolerance_m) {
  const auto count = static_cast<double>(line.stations.size());
  double along_mean = 0.0, height_scatter = 0.0, along_scatter = 0.0;
  for (const Station& station : line.stations) along_mean += station.along_m / count;
  for (const Station& station : line.stations) {
    const double along = station.along_m - along_mean;
    height_scatter += along * (station.position_m.y() - line.height_m);
    along_scatter += along * along;
  }
  const double slope = height_scatter / along_scatter;
  if (std::abs(slope) > std::tan(radians_from_degrees(kMaxObliquenessDeg))) {
    throw Error(fmt::format("the line from {} to {} climbs by {:.3g} degrees, more than {:.3g}",
                            line.stations.front().file, line.stations.back().file,
                            degrees_from_radians(std::atan(slope)), kMaxObliquenessDeg));
  }
  for (size_t i = 0; i < line.stations.size(); ++i) {
    const Station& station = line.stations[i];
    const double expected = line.height_m + slope * (station.along_m - along_mean);
    const double off = std::abs(station.position_m.y() - expected);
    if (off > tolerance_m) {
      throw Error(fmt::format(
          "{} is {:.3g} mm above or below its line, more than the tolerance of "
          "{:.3g} mm",
          name_of(stations[static_cast<size_t>(members[i])]), off * 1e3, tolerance_m * 1e3));
    }
  }
}

// The line's final fit to its own stations; along_m is 0 at the first station.
Line line_from_group(const StationGroup& group, std::span<const StationPose> stations,
                     double tolerance_m) {
  std::vector<Eigen::Vector2d> points;
  for (int member : group.stations)
    points.push_back(plan_of(stations[static_cast<size_t>(member)]));
  const PlanLine fitted = fit_line(points, group.line.axis);
  const double first = fitted.along(points.front());
  Line line;
  line.axis = fitted.axis;
  line.origin = point_of(fitted.origin + first * fitted.direction);
  line.direction = point_of(fitted.direction);
  for (size_t i = 0; i < points.size(); ++i) {
    const StationPose& pose = stations[static_cast<size_t>(group.stations[i])];
    line.stations.push_back({pose.file, pose.position_m, fitted.along(points[i]) - first});
    line.height_m += pose.position_m.y() / static_cast<double>(points.size());
  }
  check_heights(line, stations, group.stations, tolerance_m);
  return line;
}

// Lines along x in order of z, then lines along z in order of x; numbered in this order.
void sort_and_name(std::vector<Line>* lines) {
  const auto place = [](const Line& line) {
    const double middle = 0.5 * (line.first_m() + line.last_m());
    return line.axis == LineAxis::kX ? line.origin.z_m + middle * line.direction.z_m
                                     : line.origin.x_m + middle * line.direction.x_m;
  };
  std::sort(lines->begin(), lines->end(), [&](const Line& a, const Line& b) {
    return std::make_pair(a.axis, place(a)) < std::make_pair(b.axis, place(b));
  });
  int next_x = 0, next_z = 0;
  for (Line& line : *lines) {
    line.id =
        line.axis == LineAxis::kX ? fmt::format("x{}", next_x++) : fmt::format("z{}", next_z++);
  }
}

// Whether the line's stations cover the segment without a large gap. A line may end up to one
// spacing before a corner.
bool covers(const Line& line, PlanPoint from, PlanPoint to) {
  const double spacing = median_spacing_m(line);
  const double begin = along_line(line, from), end = along_line(line, to);
  if (line.first_m() > begin + spacing || line.last_m() < end - spacing) return false;
  for (size_t i = 1; i < line.stations.size(); ++i) {
    const double a = line.stations[i - 1].along_m, b = line.stations[i].along_m;
    if (b > begin && a < end && b - a > kLargestGapInSpacings * spacing) return false;
  }
  return true;
}

// The cell between two lines along x (back, front) and two along z (left, right), if captured.
std::optional<Cell> cell_between(const std::vector<Line>& lines, int back, int front, int left,
                                 int right) {
  const auto at = [&](int index) -> const Line& { return lines[static_cast<size_t>(index)]; };
  const PlanPoint back_left = crossing_of(at(back), at(left));
  const PlanPoint back_right = crossing_of(at(back), at(right));
  const PlanPoint front_left = crossing_of(at(front), at(left));
  const PlanPoint front_right = crossing_of(at(front), at(right));
  if (!covers(at(back), back_left, back_right) || !covers(at(front), front_left, front_right) ||
      !covers(at(left), back_left, front_left) || !covers(at(right), back_right, front_right)) {
    return std::nullopt;
  }
  Cell cell;
  cell.x_min_m = 0.5 * (back_left.x_m + front_left.x_m);
  cell.x_max_m = 0.5 * (back_right.x_m + front_right.x_m);
  cell.z_min_m = 0.5 * (back_left.z_m + back_right.z_m);
  cell.z_max_m = 0.5 * (front_left.z_m + front_right.z_m);
  cell.line = {front, right, back, left};
  return cell;
}

// From each back left corner, the smallest closed rectangle. A line that ends inside a rectangle
// does not split it.
std::vector<Cell> find_cells(const std::vector<Line>& lines) {
  const auto first_z = std::find_if(lines.begin(), lines.end(),
                                    [](const Line& line) { return line.axis == LineAxis::kZ; });
  const int x_lines = static_cast<int>(first_z - lines.begin());
  const int all = static_cast<int>(lines.size());
  const auto smallest_from = [&](int back, int left) -> std::optional<Cell> {
    for (int right = left + 1; right < all; ++right) {
      for (int front = back + 1; front < x_lines; ++front) {
        const std::optional<Cell> cell = cell_between(lines, back, front, left, right);
        if (cell && cell->x_min_m < cell->x_max_m && cell->z_min_m < cell->z_max_m) return cell;
      }
    }
    return std::nullopt;
  };
  std::vector<Cell> cells;
  for (int back = 0; back < x_lines; ++back) {
    for (int left = x_lines; left < all; ++left) {
      if (const std::optional<Cell> cell = smallest_from(back, left)) cells.push_back(*cell);
    }
  }
  return cells;
}

}  // namespace

double along_line(const Line& line, PlanPoint point) {
  return (vector_of(point) - vector_of(line.origin)).dot(vector_of(line.direction));
}

// origin_a + s direction_a = origin_b + t direction_b, solved for (s, t).
PlanPoint crossing_of(const Line& a, const Line& b) {
  Eigen::Matrix2d directions;
  directions << vector_of(a.direction), -vector_of(b.direction);
  const Eigen::Vector2d along = directions.inverse() * (vector_of(b.origin) - vector_of(a.origin));
  return point_of(vector_of(a.origin) + along[0] * vector_of(a.direction));
}

double median_spacing_m(const Line& line) {
  std::vector<double> spacings;
  for (size_t i = 1; i < line.stations.size(); ++i) {
    spacings.push_back(line.stations[i].along_m - line.stations[i - 1].along_m);
  }
  return median(std::move(spacings));
}

Grid find_grid(std::span<const StationPose> stations, const GridTolerance& tolerance) {
  if (stations.empty()) throw Error("there are no stations");
  check_finite(stations);
  const double tolerance_m = tolerance_for(stations, tolerance);
  std::vector<StationGroup> groups = find_lines(stations, tolerance_m);
  assign_crossing_stations(stations, tolerance_m, &groups);
  Grid grid;
  for (const StationGroup& group : groups) {
    grid.lines.push_back(line_from_group(group, stations, tolerance_m));
  }
  sort_and_name(&grid.lines);
  grid.cells = find_cells(grid.lines);
  return grid;
}

std::optional<int> find_cell(const Grid& grid, PlanPoint viewpoint) {
  for (size_t i = 0; i < grid.cells.size(); ++i) {
    const Cell& cell = grid.cells[i];
    if (viewpoint.x_m >= cell.x_min_m && viewpoint.x_m <= cell.x_max_m &&
        viewpoint.z_m >= cell.z_min_m && viewpoint.z_m <= cell.z_max_m) {
      return static_cast<int>(i);
    }
  }
  return std::nullopt;
}

}  // namespace raywalk
