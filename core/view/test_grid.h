// For tests: capture grids in closed form.
#pragma once

#include <vector>

#include "core/geometry/grid.h"

namespace raywalk {

// A line along `axis` at `place_m` on the other one, with stations at the given positions on
// `axis`.
inline Line line_at(LineAxis axis, double place_m, const std::vector<double>& positions_m) {
  Line line;
  line.axis = axis;
  line.direction = axis == LineAxis::kX ? PlanPoint{1.0, 0.0} : PlanPoint{0.0, 1.0};
  line.origin = axis == LineAxis::kX ? PlanPoint{0.0, place_m} : PlanPoint{place_m, 0.0};
  for (const double at : positions_m) {
    Station station;
    station.along_m = at;
    station.position_m = axis == LineAxis::kX ? Eigen::Vector3d(at, 0.0, place_m)
                                              : Eigen::Vector3d(place_m, 0.0, at);
    line.stations.push_back(station);
  }
  return line;
}

// One square cell of side `side_m` around the origin whose lines reach `overhang_m` beyond its
// corners, `intervals` station spacings each.
inline Grid square_grid(double side_m, double overhang_m, int intervals = 30) {
  std::vector<double> positions;
  const double first = -0.5 * side_m - overhang_m;
  for (int i = 0; i <= intervals; ++i) {
    positions.push_back(first + i * (side_m + 2.0 * overhang_m) / intervals);
  }
  const double half = 0.5 * side_m;
  Grid grid;
  grid.lines = {line_at(LineAxis::kX, half, positions), line_at(LineAxis::kZ, half, positions),
                line_at(LineAxis::kX, -half, positions), line_at(LineAxis::kZ, -half, positions)};
  grid.cells = {{-half, half, -half, half, {0, 1, 2, 3}}};
  return grid;
}

}  // namespace raywalk
