#include "core/geometry/grid.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cstddef>

#include "core/geometry/line_gaps.h"
#include "core/geometry/position_tolerance.h"

namespace raywalk {
namespace {

Eigen::Vector2d vector_of(PlanPoint point) { return {point.x_m, point.z_m}; }
PlanPoint point_of(const Eigen::Vector2d& vector) { return {vector.x(), vector.y()}; }

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
    const PlanPoint corner = intersection(back, left);
    if (!at(back).begins_at(corner) || !at(left).begins_at(corner)) return std::nullopt;
    std::vector<int> fronts;
    for (int front = back + 1; front < x_lines_; ++front) {
      if (at(left).covers(corner, intersection(front, left))) fronts.push_back(front);
    }
    for (int right = left + 1; !fronts.empty() && right < static_cast<int>(lines_.size());
         ++right) {
      if (!at(back).covers(corner, intersection(back, right))) continue;
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
    const PlanPoint back_left = intersection(back, left);
    const PlanPoint back_right = intersection(back, right);
    const PlanPoint front_left = intersection(front, left);
    const PlanPoint front_right = intersection(front, right);
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
  PlanPoint intersection(int x_line, int z_line) const {
    return intersection_of(at(x_line).line(), at(z_line).line());
  }

  std::vector<Coverage> lines_;
  int x_lines_ = 0;
};

}  // namespace

double along_line(const Line& line, PlanPoint point) {
  return (vector_of(point) - vector_of(line.origin)).dot(vector_of(line.direction));
}

std::vector<StationIndex> all_stations(const Grid& grid) {
  std::vector<StationIndex> stations;
  for (int line = 0; line < static_cast<int>(grid.lines.size()); ++line) {
    const auto count = static_cast<int>(grid.lines[static_cast<size_t>(line)].stations.size());
    for (int station = 0; station < count; ++station) stations.push_back({line, station});
  }
  return stations;
}

// origin_a + s direction_a = origin_b + t direction_b, solved for (s, t).
PlanPoint intersection_of(const Line& a, const Line& b) {
  Eigen::Matrix2d directions;
  directions << vector_of(a.direction), -vector_of(b.direction);
  const Eigen::Vector2d along = directions.inverse() * (vector_of(b.origin) - vector_of(a.origin));
  return point_of(vector_of(a.origin) + along[0] * vector_of(a.direction));
}

std::vector<Cell> find_cells(const std::vector<Line>& lines) { return CellSearch(lines).run(); }

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
