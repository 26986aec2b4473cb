#include "core/view/view_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/view/view_height.h"

namespace raywalk {
namespace {

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

std::optional<LineCrossing> cross_line(const Line& line, PlanPoint viewpoint, double theta_rad) {
  const PlanPoint ray{std::sin(theta_rad), std::cos(theta_rad)};
  const PlanPoint to_origin = minus(line.origin, viewpoint);
  // viewpoint + d_p ray = origin + along direction; crossing both sides with `direction` leaves
  // d_p.
  const double numerator = cross(to_origin, line.direction);
  const double denominator = cross(ray, line.direction);
  if (numerator == 0.0) return LineCrossing{0.0, along_line(line, viewpoint)};
  const double d_p = numerator / denominator;
  if (!std::isfinite(d_p)) return std::nullopt;
  const double along = along_line(line, viewpoint) + d_p * dot(ray, line.direction);
  return LineCrossing{d_p, along};
}

RaySource source_at(const Line& line, int line_index, const LineCrossing& crossing) {
  RaySource source;
  source.line = line_index;
  source.d_p_m = crossing.d_p_m;
  const auto& stations = line.stations;
  const auto after = std::upper_bound(
      stations.begin(), stations.end(), crossing.along_m,
      [](double along_m, const Station& station) { return along_m < station.along_m; });
  const auto last_pair = static_cast<int>(stations.size()) - 2;
  source.station = std::clamp(static_cast<int>(after - stations.begin()) - 1, 0, last_pair);
  const Station& s0 = stations[static_cast<size_t>(source.station)];
  const Station& s1 = stations[static_cast<size_t>(source.station) + 1];
  source.fraction =
      std::clamp((crossing.along_m - s0.along_m) / (s1.along_m - s0.along_m), 0.0, 1.0);
  return source;
}

ViewPlan::ViewPlan(const Grid& grid, PlanPoint viewpoint, const ConnectionRule& rule)
    : grid_(grid), viewpoint_(viewpoint) {
  if (const auto cell = find_cell(grid, viewpoint)) {
    plan_cell(grid.cells[static_cast<size_t>(*cell)], rule);
  } else if (grid.cells.empty()) {
    plan_open_grid();
  } else {
    throw Error(
        fmt::format("viewpoint {},{} m is outside every cell of the room; choose one inside "
                    "(raywalk-build-lf info lists the cells)",
                    viewpoint.x_m, viewpoint.z_m));
  }
}

ViewPlan::ViewPlan(const Grid& grid, const Eigen::Vector3d& position_m, const RaySource& between)
    : grid_(grid),
      viewpoint_{position_m.x(), position_m.z()},
      height_m_(position_m.y()),
      lines_{between.line},
      everywhere_(ColumnPlan()) {
  for (const double fraction : {0.0, 1.0}) {
    RaySource station = between;
    station.fraction = fraction;
    station.weight = fraction == 0.0 ? 1.0 - between.fraction : between.fraction;
    if (station.weight == 0.0) continue;
    everywhere_->front[static_cast<size_t>(everywhere_->front_count++)] = station;
  }
}

void ViewPlan::plan_cell(const Cell& cell, const ConnectionRule& rule) {
  closed_ = true;
  height_m_ = height_in_cell(grid_, cell, viewpoint_);
  side_lines_ = cell.line;
  lines_.assign(cell.line.begin(), cell.line.end());
  for (int side = 0; side < 4; ++side) {
    auto& corner = corners_[static_cast<size_t>(side)];
    corner = connect_corner(corner_view(grid_, cell, static_cast<Side>(side), viewpoint_), rule);
    limited_corners_ += corner.limited ? 1 : 0;
  }
}

void ViewPlan::plan_open_grid() {
  lines_.resize(grid_.lines.size());
  std::iota(lines_.begin(), lines_.end(), 0);
  height_m_ = height_beside(grid_, lines_, viewpoint_);
  // A line is crossed by some ray exactly where its captured part is seen under a positive angle or
  // the viewpoint is on it; a dense fan of rays avoids treating every degenerate case.
  constexpr int kFan = 720;
  std::array<RaySource, 2> sources;
  for (int i = 0; i < kFan; ++i) {
    if (open_sources(i * kTwoPi / kFan, sources) > 0) return;
  }
  throw Error(fmt::format(
      "no line can be seen from viewpoint {},{} m, so nothing can be rendered; choose one nearer",
      viewpoint_.x_m, viewpoint_.z_m));
}

int ViewPlan::cell_sources(double theta_rad, std::array<RaySource, 2>& sources) const {
  // Angle from the normal of the side whose quadrant holds theta, towards the next side.
  const double turn = theta_rad < 0.0 ? theta_rad + kTwoPi : theta_rad;
  const int side = std::clamp(static_cast<int>(turn / kHalfPi), 0, 3);
  const double angle = turn - side * kHalfPi;
  const double next_weight = next_side_weight(corners_[static_cast<size_t>(side)], angle);
  int count = 0;
  for (int which = 0; which < 2; ++which) {
    const double weight = which == 0 ? 1.0 - next_weight : next_weight;
    if (weight <= 0.0) continue;
    const int line = side_lines_[static_cast<size_t>((side + which) % 4)];
    const Line& geometry = grid_.lines[static_cast<size_t>(line)];
    // With a connection at 0 or 90 degrees the viewpoint is on the line that the ray runs along, up
    // to rounding of the line's fit: the acquisition point is the viewpoint itself.
    const LineCrossing crossing =
        cross_line(geometry, viewpoint_, theta_rad)
            .value_or(LineCrossing{0.0, along_line(geometry, viewpoint_)});
    sources[static_cast<size_t>(count)] = source_at(geometry, line, crossing);
    sources[static_cast<size_t>(count)].weight = weight;
    ++count;
  }
  return count;
}

int ViewPlan::open_sources(double theta_rad, std::array<RaySource, 2>& sources) const {
  int count = 0;
  for (const int line : lines_) {
    const Line& geometry = grid_.lines[static_cast<size_t>(line)];
    const auto crossing = cross_line(geometry, viewpoint_, theta_rad);
    if (!crossing || crossing->d_p_m < 0.0) continue;
    if (crossing->along_m < geometry.first_m() || crossing->along_m > geometry.last_m()) continue;
    if (count == 1 && crossing->d_p_m >= sources[0].d_p_m) continue;
    sources[0] = source_at(geometry, line, *crossing);
    count = 1;
  }
  return count;
}

int ViewPlan::front_sources(double theta_rad, std::array<RaySource, 2>& sources) const {
  return closed_ ? cell_sources(theta_rad, sources) : open_sources(theta_rad, sources);
}

ColumnPlan ViewPlan::column(double theta_rad) const {
  if (everywhere_) return *everywhere_;
  ColumnPlan plan;
  plan.front_count = front_sources(wrap_angle(theta_rad), plan.front);
  // The line behind is the line in front of the opposite column, at negative distance.
  plan.behind_count = front_sources(wrap_angle(theta_rad + kPi), plan.behind);
  for (int i = 0; i < plan.behind_count; ++i) {
    plan.behind[static_cast<size_t>(i)].d_p_m = -plan.behind[static_cast<size_t>(i)].d_p_m;
  }
  return plan;
}

}  // namespace raywalk
