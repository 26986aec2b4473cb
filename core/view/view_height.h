// The height of a view: that of the stations around it, which may go up and down hill.
#pragma once

#include <span>

#include "core/geometry/grid.h"

namespace raywalk {

// The height of a line near `along_m`, metres: a straight line fitted to the heights of the
// stations around, with weights that fall to 0 at four spacings, so that it follows a hill and
// averages what single stations are off. It is continuous; beyond the ends it is that of the end.
double height_along(const Line& line, double along_m);

// At a viewpoint: in its cell, or beside all lines where it is in none.
double height_around(const Grid& grid, PlanPoint viewpoint);

// At a viewpoint in a cell: interpolated between opposite sides, averaged over both pairs of them.
double height_in_cell(const Grid& grid, const Cell& cell, PlanPoint viewpoint);

// At a viewpoint beside lines (indices into Grid::lines): their mean.
double height_beside(const Grid& grid, std::span<const int> lines, PlanPoint viewpoint);

}  // namespace raywalk
