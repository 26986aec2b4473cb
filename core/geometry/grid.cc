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
#include "core/geometry/length_text.h"
#include "core/geometry/line_gaps.h"
#include "core/geometry/line_heights.h"
#include "core/geometry/line_search.h"
#include "core/geometry/position_tolerance.h"
#include "core/geometry/station_spacing.h"
#include "core/geometry/unplaced_stations.h"

namespace raywalk {
namespace {

Eigen::Vector2d vector_of(PlanPoint point) { return {point.x_m, point.z_m}; }
PlanPoint point_of(const Eigen::Vector2d& vector) { return {vector.x(), vector.y()}; }

void check_finite(std::span<const StationPose> stations) {
  for (const StationPose& station : stations) {
    if (!station.position_m.allFinite()) {
      throw Error(fmt::format("{}: the position is not finite", name_of(station)));
    }
  }
}

double rounding_of(std::span<const StationPose> stations) {
  double largest_m = 0.0;
  for (const StationPose& station : stations) {
    largest_m = std::max(largest_m, station.position_m.cwiseAbs().maxCoeff());
  }
  return rounding_m(largest_m);
}

// The limits for stations that are typically `spacing_m` apart.
LineLimits limits_for(std::span<const StationPose> stations, const GridTolerance& tolerance,
                      double spacing_m) {
  constexpr double kSameStationShare = 0.002, kLeastShare = 1e-9;
  Eigen::AlignedBox3d extent;
  for (const StationPose& station : stations) extent.extend(station.position_m);
  const double rounding = rounding_of(stations);
  const double least_m = kLeastShare * extent.diagonal().norm() + 2.0 * rounding;
  LineLimits limits;
  limits.off_line_m =
      tolerance.off_line_m.value_or(std::max(kOffPlaceShare * spacing_m, least_m)) + rounding;
  limits.same_station_m =
      rounding + tolerance.same_station_m.value_or(std::min(
                     std::max(kSameStationShare * spacing_m, least_m), 0.5 * limits.off_line_m));
  if (limits.same_station_m > limits.off_line_m) {
    throw Error(fmt::format(
        "stations within {} count as one, but a station may be only {} off its line; give a "
        "smaller --same-station-mm or a larger --line-tolerance-mm",
        mm_text(limits.same_station_m), mm_text(limits.off_line_m)));
  }
  limits.twin_m =
      std::max(limits.same_station_m, std::min(limits.off_line_m, kOffPlaceShare * spacing_m));
  return limits;
}

// The line's final fit to its own stations; along_m is 0 at the first station.
Line line_from_group(const StationGroup& group, std::span<const StationPose> stations,
                     const LineLimits& limits) {
  const PlanLine fitted = line_through(stations, group.stations, group.line.axis);
  const auto along = [&](int member) {
    return fitted.along(plan_of(stations[static_cast<size_t>(member)]));
  };
  std::vector<int> members = group.stations;
  std::stable_sort(members.begin(), members.end(),
                   [&](int a, int b) { return along(a) < along(b); });
  const double first = along(members.front());
  // Stations side by side have the same place along the line, which must increase.
  constexpr double kLeastStep = 1e-9;
  const double least_step_m = kLeastStep * (along(members.back()) - first);
  if (least_step_m <= 0.0) {
    throw Error(fmt::format("{} and {} are side by side and on no line; leave one of them out",
                            name_of(stations[static_cast<size_t>(members.front())]),
                            name_of(stations[static_cast<size_t>(members.back())])));
  }
  Line line;
  std::vector<std::string> names;
  line.axis = fitted.axis;
  line.origin = point_of(fitted.origin + first * fitted.direction);
  line.direction = point_of(fitted.direction);
  for (const int member : members) {
    const StationPose& pose = stations[static_cast<size_t>(member)];
    double along_m = along(member) - first;
    if (!line.stations.empty()) along_m = std::max(along_m, line.last_m() + least_step_m);
    line.stations.push_back({pose.file, pose.position_m, along_m});
    names.push_back(name_of(pose));
    line.height_m += pose.position_m.y() / static_cast<double>(members.size());
  }
  check_heights(line, names, limits.off_line_m);
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

// Whether a line's stations cover a segment without a missing section. A line may end up to one
// spacing before a corner: the station there may be of the line that crosses.
class Coverage {
 public:
  explicit Coverage(const Line& line)
      : line_(line), reach_m_(reach_of(line)), missing_(missing_sections(line)) {}

  const Line& line() const { return line_; }
  bool begins_at(PlanPoint from) const {
    return line_.first_m() <= along_line(line_, from) + reach_m_;
  }
  bool covers(PlanPoint from, PlanPoint to) const {
    const double begin_m = along_line(line_, from) + reach_m_;
    const double end_m = along_line(line_, to) - reach_m_;
    if (line_.first_m() > begin_m || line_.last_m() < end_m) return false;
    return std::none_of(missing_.begin(), missing_.end(), [&](const LineGap& gap) {
      return gap.to_m > begin_m && gap.from_m < end_m;
    });
  }

 private:
  static double reach_of(const Line& line) {
    const double spacing_m = covering_spacing(line);
    return spacing_m + place_tolerance_m(line, spacing_m);
  }

  const Line& line_;
  double reach_m_;
  std::vector<LineGap> missing_;
};

// The lines of a grid, those along x first.
class CellSearch {
 public:
  explicit CellSearch(const std::vector<Line>& lines) {
    for (const Line& line : lines) lines_.emplace_back(line);
    const auto first_z = std::find_if(lines.begin(), lines.end(),
                                      [](const Line& line) { return line.axis == LineAxis::kZ; });
    x_lines_ = static_cast<int>(first_z - lines.begin());
  }

  // From each back left corner, the smallest closed rectangle. A line that ends inside a rectangle
  // does not split it.
  std::vector<Cell> run() const {
    std::vector<Cell> cells;
    for (int back = 0; back < x_lines_; ++back) {
      for (int left = x_lines_; left < static_cast<int>(lines_.size()); ++left) {
        if (const std::optional<Cell> cell = smallest_from(back, left)) cells.push_back(*cell);
      }
    }
    return cells;
  }

 private:
  std::optional<Cell> smallest_from(int back, int left) const {
    const PlanPoint corner = crossing(back, left);
    if (!at(back).begins_at(corner) || !at(left).begins_at(corner)) return std::nullopt;
    std::vector<int> fronts;
    for (int front = back + 1; front < x_lines_; ++front) {
      if (at(left).covers(corner, crossing(front, left))) fronts.push_back(front);
    }
    for (int right = left + 1; !fronts.empty() && right < static_cast<int>(lines_.size());
         ++right) {
      if (!at(back).covers(corner, crossing(back, right))) continue;
      for (const int front : fronts) {
        const std::optional<Cell> cell = cell_between(back, front, left, right);
        if (cell && cell->x_min_m < cell->x_max_m && cell->z_min_m < cell->z_max_m) return cell;
      }
    }
    return std::nullopt;
  }

  // The cell between two lines along x (back, front) and two along z (left, right), if front and
  // right are captured.
  std::optional<Cell> cell_between(int back, int front, int left, int right) const {
    const PlanPoint back_left = crossing(back, left);
    const PlanPoint back_right = crossing(back, right);
    const PlanPoint front_left = crossing(front, left);
    const PlanPoint front_right = crossing(front, right);
    if (!at(front).covers(front_left, front_right) || !at(right).covers(back_right, front_right)) {
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

  const Coverage& at(int index) const { return lines_[static_cast<size_t>(index)]; }
  PlanPoint crossing(int x_line, int z_line) const {
    return crossing_of(at(x_line).line(), at(z_line).line());
  }

  std::vector<Coverage> lines_;
  int x_lines_ = 0;
};

Grid grid_within(std::span<const StationPose> stations, const LineLimits& limits) {
  FoundLines found = find_lines(stations, limits);
  if (!found.unplaced.empty()) throw_unplaced(stations, limits, found.groups, found.unplaced);
  require_lines_apart(stations, limits, found.groups);
  assign_crossing_stations(stations, limits, &found.groups);
  Grid grid;
  for (const StationGroup& group : found.groups) {
    grid.lines.push_back(line_from_group(group, stations, limits));
  }
  sort_and_name(&grid.lines);
  grid.cells = CellSearch(grid.lines).run();
  return grid;
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
  const double spacing_m = typical_spacing(stations);
  try {
    return grid_within(stations, limits_for(stations, tolerance, spacing_m));
  } catch (const UsageError&) {
    throw;
  } catch (const Error&) {
    // Lines of a few stations each are closer together than their stations suggest.
    if (tolerance.off_line_m) throw;
    const double nearest_m = median_nearest_distance(stations);
    if (nearest_m >= spacing_m - rounding_of(stations)) throw;
    try {
      return grid_within(stations, limits_for(stations, tolerance, nearest_m));
    } catch (const Error&) {
    }
    throw;
  }
}

bool contains(const Cell& cell, PlanPoint viewpoint) {
  const double rounding = rounding_m(largest_coordinate_m(viewpoint));
  return viewpoint.x_m >= cell.x_min_m - rounding && viewpoint.x_m <= cell.x_max_m + rounding &&
         viewpoint.z_m >= cell.z_min_m - rounding && viewpoint.z_m <= cell.z_max_m + rounding;
}

std::optional<int> find_cell(const Grid& grid, PlanPoint viewpoint) {
  for (size_t i = 0; i < grid.cells.size(); ++i) {
    if (contains(grid.cells[i], viewpoint)) return static_cast<int>(i);
  }
  return std::nullopt;
}

}  // namespace raywalk
