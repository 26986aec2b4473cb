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

// Whether a line's stations cover a segment without a large gap. A line may end up to one
// spacing before a corner.
class Coverage {
 public:
  explicit Coverage(const Line& line) : line_(line), spacing_m_(median_spacing_m(line)) {
    for (size_t i = 1; i < line.stations.size(); ++i) {
      const double a = line.stations[i - 1].along_m, b = line.stations[i].along_m;
      if (b - a > kLargestGapInSpacings * spacing_m_) gaps_m_.emplace_back(a, b);
    }
  }

  const Line& line() const { return line_; }
  bool begins_at(PlanPoint from) const {
    return line_.first_m() <= along_line(line_, from) + spacing_m_;
  }
  bool covers(PlanPoint from, PlanPoint to) const {
    const double begin = along_line(line_, from), end = along_line(line_, to);
    if (line_.first_m() > begin + spacing_m_ || line_.last_m() < end - spacing_m_) return false;
    return std::none_of(gaps_m_.begin(), gaps_m_.end(), [&](const std::pair<double, double>& gap) {
      return gap.second > begin && gap.first < end;
    });
  }

 private:
  const Line& line_;
  double spacing_m_;
  std::vector<std::pair<double, double>> gaps_m_;  // the large ones
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
  grid.cells = CellSearch(grid.lines).run();
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
