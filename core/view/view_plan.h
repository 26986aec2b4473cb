// The plan of a view: the lines, stations and weights that every column of an output panorama is
// read from.
//
// The ray of column theta leaves the viewpoint P and crosses a line at the acquisition point A, at
// the signed plan distance d_p (negative for the line behind P, which is in the same vertical
// plane). With a circle of eyes (core/geometry/eye_circle.h) every column has a viewpoint P of its
// own.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/eye_circle.h"
#include "core/geometry/grid.h"
#include "core/view/connection.h"
#include "core/view/viewpoint.h"

namespace raywalk {

// One line a column is read from.
struct RaySource {
  int line = -1;          // index into Grid::lines
  int station = 0;        // the station before A; station + 1 is the one after it
  double fraction = 0.0;  // of the way from `station` to `station + 1`, in [0, 1]
  double d_p_m = 0.0;     // signed plan distance from P to A along the column's direction
  double weight = 1.0;    // share in the blend of a connection, in (0, 1]
};

// At most two lines in front (at a connection) and two behind.
struct ColumnPlan {
  std::array<RaySource, 2> front;
  std::array<RaySource, 2> behind;
  int front_count = 0;
  int behind_count = 0;
};

// Where a ray from the viewpoint in plan direction theta crosses a line.
struct LineIntersection {
  double d_p_m = 0.0;    // signed
  double along_m = 0.0;  // position on the line, may lie outside what was captured
};

// The intersection; none if the ray runs parallel to a line it is not on.
std::optional<LineIntersection> cross_line(const Line& line, PlanPoint viewpoint, double theta_rad);

// The source for an intersection; positions outside the captured part are clamped to its end.
RaySource source_at(const Line& line, int line_index, const LineIntersection& intersection);

// The plan of one view.
class ViewPlan {
 public:
  // A viewpoint in a closed cell is rendered from the cell's four lines, connected by `rule`. In a
  // grid that closes no cell (a single line is the paper's 3D360) a column is rendered from the
  // nearest line that its ray crosses, and left empty where there is none. With an `eye_radius_m`
  // (EyeCircle::radius_m) every column is planned from its own place on the circle around the
  // viewpoint, which may reach into several cells. Throws Error when the grid has cells and a place
  // is in none of them, or when no column can be rendered.
  ViewPlan(const Grid& grid, const Viewpoint& viewpoint, const ConnectionRule& rule,
           double eye_radius_m = 0.0);

  const EyeCircle& eye() const { return eye_; }
  // The circle's centre; without a circle the place of the eye.
  PlanPoint viewpoint() const { return {eye_.centre_m.x(), eye_.centre_m.z()}; }
  // Height of the view: the one asked for, else that of the lines that serve it, around the
  // viewpoint (view_height.h).
  double height_m() const { return eye_.centre_m.y(); }
  // How far it is above the height of the lines; 0 where no height was asked for.
  double above_lines_m() const { return above_lines_m_; }
  // Lines that serve the view.
  std::span<const int> lines() const { return lines_; }
  // Number of corners, of four, whose connection was moved because the overhang ran out, seen from
  // the viewpoint.
  int limited_corners() const { return limited_corners_; }

  // `theta_rad` is wrapped; front_count is 0 where no line serves the column.
  ColumnPlan column(double theta_rad) const;

 private:
  using Sources = std::array<RaySource, 2>;

  void plan_cell();
  void plan_circle();
  void plan_open_grid();
  // The lines that a ray from a place crosses.
  int front_sources(PlanPoint from, double theta_rad, Sources& sources) const;
  int cell_sources(PlanPoint from, double theta_rad, Sources& sources) const;
  int open_sources(PlanPoint from, double theta_rad, Sources& sources) const;
  // The cell of a place; of one that is in none, that of the viewpoint.
  const Cell& cell_of(PlanPoint place) const;
  CornerConnection corner_of(const Cell& cell, Side side, PlanPoint from) const;

  const Grid& grid_;
  ConnectionRule rule_;
  EyeCircle eye_;
  double above_lines_m_ = 0.0;
  std::vector<int> lines_;
  const Cell* cell_ = nullptr;                 // of the viewpoint; null in an open grid
  std::array<CornerConnection, 4> corners_{};  // corner i joins side i and side i + 1 of it
  int limited_corners_ = 0;
};

// The corner between side `side` and the next one (clockwise seen from above) as seen from a
// viewpoint in the cell.
CornerView corner_view(const Grid& grid, const Cell& cell, Side side, PlanPoint viewpoint);

// Direction of a side's outward normal: 0 for front, 90 deg for right, and so on.
double side_normal_rad(Side side);

}  // namespace raywalk
