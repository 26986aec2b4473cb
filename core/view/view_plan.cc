#include "core/view/view_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/geometry/position_tolerance.h"
#include "core/view/view_height.h"

namespace raywalk {
namespace {

// Rays, or places on a circle, that stand for all of them.
constexpr int kFan = 720;

double cross(PlanPoint p, PlanPoint q) { return p.x_m * q.z_m - p.z_m * q.x_m; }
double dot(PlanPoint p, PlanPoint q) { return p.x_m * q.x_m + p.z_m * q.z_m; }
PlanPoint minus(PlanPoint p, PlanPoint q) { return {p.x_m - q.x_m, p.z_m - q.z_m}; }

double distance_to_side(const Cell& cell, Side side, PlanPoint viewpoint) {
  switch (side) {
    case Side::kFront:
      return cell.z_max_m - viewpoint.z_m;
    case Side::kRight:
      return cell.x_max_m - viewpoint.x_m;
    case Side::kBack:
      return viewpoint.z_m - cell.z_min_m;
    case Side::kLeft:
      return viewpoint.x_m - cell.x_min_m;
  }
  return 0.0;
}

// The corner where a side meets the next one, clockwise seen from above.
PlanPoint corner_after(const Cell& cell, Side side) {
  switch (side) {
    case Side::kFront:
      return {cell.x_max_m, cell.z_max_m};
    case Side::kRight:
      return {cell.x_max_m, cell.z_min_m};
    case Side::kBack:
      return {cell.x_min_m, cell.z_min_m};
    case Side::kLeft:
      return {cell.x_min_m, cell.z_max_m};
  }
  return {};
}

Side next_side(Side side) { return static_cast<Side>((static_cast<int>(side) + 1) % 4); }

// Captured length of a line beyond a corner, away from the cell's centre.
double overhang(const Line& line, PlanPoint corner, PlanPoint centre) {
  const double at = along_line(line, corner);
  const bool towards_end = at > along_line(line, centre);
  return std::max(0.0, towards_end ? line.last_m() - at : at - line.first_m());
}

// The place inside a cell nearest to one outside all, to the millimetre.
PlanPoint nearest_inside(const std::vector<Cell>& cells, PlanPoint from) {
  const auto within = [](double value, double least, double most) {
    return std::min(std::max(value, std::ceil(1e3 * least) / 1e3), std::floor(1e3 * most) / 1e3);
  };
  const auto inside = [&](const Cell& cell) {
    return PlanPoint{within(from.x_m, cell.x_min_m, cell.x_max_m),
                     within(from.z_m, cell.z_min_m, cell.z_max_m)};
  };
  const auto apart_m = [&](const Cell& cell) {
    return std::hypot(inside(cell).x_m - from.x_m, inside(cell).z_m - from.z_m);
  };
  return inside(*std::ranges::min_element(cells, {}, apart_m));
}

}  // namespace

double side_normal_rad(Side side) { return static_cast<int>(side) * kHalfPi; }

CornerView corner_view(const Grid& grid, const Cell& cell, Side side, PlanPoint viewpoint) {
  const Side next = next_side(side);
  const PlanPoint corner = corner_after(cell, side);
  const PlanPoint centre{0.5 * (cell.x_min_m + cell.x_max_m), 0.5 * (cell.z_min_m + cell.z_max_m)};
  const auto line_of = [&](Side s) -> const Line& {
    return grid.lines[static_cast<size_t>(cell.line[static_cast<size_t>(s)])];
  };
  return {.to_next_side_m = std::max(0.0, distance_to_side(cell, next, viewpoint)),
          .to_this_side_m = std::max(0.0, distance_to_side(cell, side, viewpoint)),
          .overhang_this_m = overhang(line_of(side), corner, centre),
          .overhang_next_m = overhang(line_of(next), corner, centre)};
}

std::optional<LineIntersection> cross_line(const Line& line, PlanPoint viewpoint,
                                           double theta_rad) {
  const PlanPoint ray{std::sin(theta_rad), std::cos(theta_rad)};
  const PlanPoint to_origin = minus(line.origin, viewpoint);
  // viewpoint + d_p ray = origin + along direction; intersection both sides with `direction` leaves
  // d_p.
  const double numerator = cross(to_origin, line.direction);
  const double denominator = cross(ray, line.direction);
  // The viewpoint is on the line: rays along it have no other intersection.
  const double rounding =
      rounding_m(largest_coordinate_m(viewpoint) + largest_coordinate_m(line.origin));
  if (std::abs(numerator) <= rounding) return LineIntersection{0.0, along_line(line, viewpoint)};
  const double d_p = numerator / denominator;
  if (!std::isfinite(d_p)) return std::nullopt;
  const double along = along_line(line, viewpoint) + d_p * dot(ray, line.direction);
  return LineIntersection{d_p, along};
}

RaySource source_at(const Line& line, int line_index, const LineIntersection& intersection) {
  RaySource source;
  source.line = line_index;
  source.d_p_m = intersection.d_p_m;
  const auto& stations = line.stations;
  const auto after = std::upper_bound(
      stations.begin(), stations.end(), intersection.along_m,
      [](double along_m, const Station& station) { return along_m < station.along_m; });
  const auto last_pair = static_cast<int>(stations.size()) - 2;
  source.station = std::clamp(static_cast<int>(after - stations.begin()) - 1, 0, last_pair);
  const Station& s0 = stations[static_cast<size_t>(source.station)];
  const Station& s1 = stations[static_cast<size_t>(source.station) + 1];
  source.fraction =
      std::clamp((intersection.along_m - s0.along_m) / (s1.along_m - s0.along_m), 0.0, 1.0);
  return source;
}

ViewPlan::ViewPlan(const Grid& grid, const Viewpoint& viewpoint, const ConnectionRule& rule,
                   double eye_radius_m)
    : grid_(grid), rule_(rule) {
  const PlanPoint at = viewpoint.plan;
  const double lines_m = height_around(grid, at);
  eye_ = {{at.x_m, viewpoint.height_m.value_or(lines_m), at.z_m}, eye_radius_m};
  above_lines_m_ = height_m() - lines_m;
  if (const auto cell = find_cell(grid, at)) {
    cell_ = &grid.cells[static_cast<size_t>(*cell)];
    plan_cell();
  } else if (grid.cells.empty()) {
    plan_open_grid();
  } else {
    const PlanPoint inside = nearest_inside(grid.cells, at);
    throw Error(
        fmt::format("viewpoint {},{} m is outside every cell of the room; choose one inside, the "
                    "nearest is {:g},{:g} (raywalk-build-lf info lists the cells)",
                    at.x_m, at.z_m, inside.x_m, inside.z_m));
  }
}

void ViewPlan::plan_cell() {
  lines_.assign(cell_->line.begin(), cell_->line.end());
  for (int side = 0; side < 4; ++side) {
    auto& corner = corners_[static_cast<size_t>(side)];
    corner = corner_of(*cell_, static_cast<Side>(side), viewpoint());
    limited_corners_ += corner.limited ? 1 : 0;
  }
  if (eye_.radius_m != 0.0) plan_circle();
}

// The lines of all cells that the circle reaches into.
void ViewPlan::plan_circle() {
  for (int i = 0; i < kFan; ++i) {
    const auto cell = find_cell(grid_, eye_.place(i * kTwoPi / kFan));
    if (!cell) {
      throw Error(
          fmt::format("the eyes of viewpoint {},{} m turn on a circle of {:g} m around it, which "
                      "reaches outside "
                      "every cell of the room; choose a viewpoint farther inside",
                      viewpoint().x_m, viewpoint().z_m, std::abs(eye_.radius_m)));
    }
    for (const int line : grid_.cells[static_cast<size_t>(*cell)].line) {
      if (std::ranges::find(lines_, line) == lines_.end()) lines_.push_back(line);
    }
  }
}

void ViewPlan::plan_open_grid() {
  lines_.resize(grid_.lines.size());
  std::iota(lines_.begin(), lines_.end(), 0);
  // A line is crossed by some ray exactly where its captured part is seen under a positive angle or
  // the viewpoint is on it; a dense fan of rays avoids treating every degenerate case.
  Sources sources;
  for (int i = 0; i < kFan; ++i) {
    const double theta_rad = i * kTwoPi / kFan;
    if (open_sources(eye_.place(theta_rad), theta_rad, sources) > 0) return;
  }
  throw Error(fmt::format(
      "no line can be seen from viewpoint {},{} m, so nothing can be rendered; choose one nearer",
      viewpoint().x_m, viewpoint().z_m));
}

const Cell& ViewPlan::cell_of(PlanPoint place) const {
  if (eye_.radius_m == 0.0 || contains(*cell_, place)) return *cell_;
  const auto cell = find_cell(grid_, place);
  return cell ? grid_.cells[static_cast<size_t>(*cell)] : *cell_;
}

CornerConnection ViewPlan::corner_of(const Cell& cell, Side side, PlanPoint from) const {
  return connect_corner(corner_view(grid_, cell, side, from), rule_);
}

int ViewPlan::cell_sources(PlanPoint from, double theta_rad, Sources& sources) const {
  // Angle from the normal of the side whose quadrant holds theta, towards the next side.
  const double turn = theta_rad < 0.0 ? theta_rad + kTwoPi : theta_rad;
  const int side = std::clamp(static_cast<int>(turn / kHalfPi), 0, 3);
  const double angle = turn - side * kHalfPi;
  const Cell& cell = cell_of(from);
  const double next_weight =
      next_side_weight(eye_.radius_m == 0.0 ? corners_[static_cast<size_t>(side)]
                                            : corner_of(cell, static_cast<Side>(side), from),
                       angle);
  int count = 0;
  for (int which = 0; which < 2; ++which) {
    const double weight = which == 0 ? 1.0 - next_weight : next_weight;
    if (weight <= 0.0) continue;
    const int line = cell.line[static_cast<size_t>((side + which) % 4)];
    const Line& geometry = grid_.lines[static_cast<size_t>(line)];
    // With a connection at 0 or 90 degrees the viewpoint is on the line that the ray runs along, up
    // to rounding of the line's fit: the acquisition point is the viewpoint itself.
    const LineIntersection intersection =
        cross_line(geometry, from, theta_rad)
            .value_or(LineIntersection{0.0, along_line(geometry, from)});
    sources[static_cast<size_t>(count)] = source_at(geometry, line, intersection);
    sources[static_cast<size_t>(count)].weight = weight;
    ++count;
  }
  return count;
}

int ViewPlan::open_sources(PlanPoint from, double theta_rad, Sources& sources) const {
  int count = 0;
  for (const int line : lines_) {
    const Line& geometry = grid_.lines[static_cast<size_t>(line)];
    const auto intersection = cross_line(geometry, from, theta_rad);
    if (!intersection || intersection->d_p_m < 0.0) continue;
    if (!is_captured_at(geometry, intersection->along_m)) continue;
    if (count == 1 && intersection->d_p_m >= sources[0].d_p_m) continue;
    sources[0] = source_at(geometry, line, *intersection);
    count = 1;
  }
  return count;
}

int ViewPlan::front_sources(PlanPoint from, double theta_rad, Sources& sources) const {
  return cell_ != nullptr ? cell_sources(from, theta_rad, sources)
                          : open_sources(from, theta_rad, sources);
}

ColumnPlan ViewPlan::column(double theta_rad) const {
  const PlanPoint from = eye_.place(theta_rad);
  ColumnPlan plan;
  plan.front_count = front_sources(from, wrap_angle(theta_rad), plan.front);
  // The line behind is the line in front of the opposite direction, at negative distance.
  plan.behind_count = front_sources(from, wrap_angle(theta_rad + kPi), plan.behind);
  for (int i = 0; i < plan.behind_count; ++i) {
    plan.behind[static_cast<size_t>(i)].d_p_m = -plan.behind[static_cast<size_t>(i)].d_p_m;
  }
  return plan;
}

}  // namespace raywalk
