// The capture grid: stations on lines, lines that bound square or rectangular cells.
//
// A line runs along x or along z. It is fitted to its stations, so it may be slightly oblique and
// off its planned place. Four lines close a cell.
#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {

// Which plan axis a line follows.
enum class LineAxis { kX, kZ };

// "x" or "z".
constexpr std::string_view name_of(LineAxis axis) { return axis == LineAxis::kX ? "x" : "z"; }

// One captured position on a line.
struct Station {
  std::string file;                     // as named in the frame list
  Eigen::Vector3d position_m{0, 0, 0};  // world frame; need not lie exactly on the fitted line
  double along_m = 0.0;                 // position along the fitted line, from Line::origin
};

// One straight run of the slider. `direction` is a unit vector in the plan with a positive
// component along `axis`; a point on the line is origin + along_m * direction.
struct Line {
  std::string id{};  // "x0", "x1", ... ordered by z; "z0", "z1", ... ordered by x
  LineAxis axis = LineAxis::kX;
  PlanPoint origin;  // world position of along_m = 0
  PlanPoint direction{1.0, 0.0};
  double height_m = 0.0;  // mean y of the stations
  // At least two, along_m strictly increasing; of stations side by side by 1e-9 of the line.
  std::vector<Station> stations{};

  double first_m() const { return stations.front().along_m; }
  double last_m() const { return stations.back().along_m; }
};

// The sides of a cell, in index order.
enum class Side : int { kFront = 0, kRight = 1, kBack = 2, kLeft = 3 };

// A rectangle of the plan whose four sides were captured. Bounds in world metres; `line[side]`
// indexes Grid::lines.
struct Cell {
  double x_min_m = 0.0, x_max_m = 0.0, z_min_m = 0.0, z_max_m = 0.0;
  std::array<int, 4> line{-1, -1, -1, -1};
};

// A station by its indices in Grid::lines and Line::stations.
struct StationIndex {
  int line = 0;
  int station = 0;
  friend bool operator==(StationIndex, StationIndex) = default;
  friend std::strong_ordering operator<=>(StationIndex a, StationIndex b) {
    return a.line != b.line ? a.line <=> b.line : a.station <=> b.station;
  }
};

struct Grid {
  std::vector<Line> lines;
  std::vector<Cell> cells;  // empty if no four lines close one

  const Line& line_of(StationIndex index) const { return lines[static_cast<size_t>(index.line)]; }
  const Station& station(StationIndex index) const {
    return line_of(index).stations[static_cast<size_t>(index.station)];
  }
};

// The stations of all lines, in their order.
std::vector<StationIndex> all_stations(const Grid& grid);

// A station before it has been assigned to a line.
struct StationPose {
  std::string file;
  Eigen::Vector3d position_m{0, 0, 0};
  std::string where{};  // where the pose was read, for errors ("poses.csv:12"); may be empty
  std::string line{};   // the name of its line; empty: to be found from the positions
};

struct GridTolerance {
  // Maximum distance of a station from its line, metres; at most the typical distance between
  // stations, unless lines are named. None: a tenth of the typical distance
  // between stations (line_gaps.h), half of it where lines are named, at least 1e-9 of the
  // grid's extent.
  std::optional<double> off_line_m{};
  // Distance within which two stations of a line count as one, metres; at most off_line_m. None:
  // 1/500 of the typical distance, at most half of off_line_m.
  std::optional<double> same_station_m{};
};

// The orthogonal projection of a point onto a line, as along_m.
double along_line(const Line& line, PlanPoint point);

// Where two lines of different axes intersect, each taken as infinitely long.
PlanPoint intersection_of(const Line& a, const Line& b);

// Groups stations into lines along x and z, by the names of the lines or else by their positions,
// fits each line, and finds the cells. Stations may be unevenly spaced, as of several passes of one
// line, and off their line within the tolerance, to the side and in height; their positions are
// kept as they are. Lines never share a station: one captured at an intersection belongs to one of
// the two lines. Throws Error that names stations, distances and limits when a station belongs to
// no line, two stations of a line count as one, a line has only one station, only some stations
// name their line, heights do not fit (or y is exchanged with x or z), or a coordinate is not
// finite.
Grid find_grid(std::span<const StationPose> stations, const GridTolerance& tolerance);

// The cells that these lines close; those along x come first.
std::vector<Cell> find_cells(const std::vector<Line>& lines);

// Whether a cell contains a viewpoint, borders included, which lie where the lines were fitted:
// what that loses in floating point counts as inside (position_tolerance.h).
bool contains(const Cell& cell, PlanPoint viewpoint);

// Index of the cell that contains the viewpoint; the first in Grid::cells if several do, none if no
// cell does.
std::optional<int> find_cell(const Grid& grid, PlanPoint viewpoint);

}  // namespace raywalk
