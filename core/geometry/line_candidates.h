// Bounds for the search of lines through a station. Internal to find_grid (grid.h).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk {

// For each of `points` an upper bound, which is rarely too large, of how many of them lie within
// `limit_m` of the line through it and the seed. Point p lies within that of a line of direction t
// if t is within asin(limit / |p - seed|) of the direction of p, modulo pi; the intervals that hold
// a direction are counted with their sorted ends, in n log n.
std::vector<int> most_near_lines(const Eigen::Vector2d& seed,
                                 const std::vector<Eigen::Vector2d>& points, LineAxis axis,
                                 double limit_m);

}  // namespace raywalk
