// How far apart positions may be that are meant to be the same. Every comparison of positions along
// lines, at intersections and of cells allows for one of these two:
//
// - What floating point loses (rounding_m). A decimal is stored to half a unit in the last place,
//   and each difference, projection, fit and intersection of such coordinates adds as much again.
//   This scales with the coordinates and not with the length compared: 56 - 55.98 is 0.02 + 4e-15.
// - What a list loses (place_tolerance_m). A third of a decimetre written as 0.033 gives spacings
//   of 33 and 34 mm, and a pose that was measured is not quite where it was planned. Stations
//   count as evenly spaced if each is within a tenth of their spacing of its place, along the line
//   as well as beside it (GridTolerance). A station that is missing makes a whole spacing.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/grid.h"

namespace raywalk {

// Of the distance between neighbours on a line: how far from its place a station may be.
inline constexpr double kOffPlaceShare = 0.1;

// An upper bound, metres, of the error of a length or position along a line that is computed from
// coordinates of up to `largest_m` in size. A position along a line takes about ten operations, and
// its fit adds up thousands of stations, whose errors mostly cancel: 64 units in the last place
// (1.4e-14 of the size; 1.4 nm at 100 km) are several times what was seen.
constexpr double rounding_m(double largest_m) {
  constexpr double kUnitsInLastPlace = 64.0;
  return kUnitsInLastPlace * std::numeric_limits<double>::epsilon() * largest_m;
}

// The size of the largest of these coordinates, metres.
inline double largest_coordinate_m(PlanPoint point) {
  return std::max(std::abs(point.x_m), std::abs(point.z_m));
}

// rounding_m of positions along a line.
inline double rounding_m(const Line& line) {
  return rounding_m(largest_coordinate_m(line.origin) +
                    std::max(std::abs(line.first_m()), std::abs(line.last_m())));
}

// Whether a place along a line is between its first and its last station.
inline bool is_captured_at(const Line& line, double along_m) {
  return along_m >= line.first_m() - rounding_m(line) &&
         along_m <= line.last_m() + rounding_m(line);
}

// How far apart two places along a line may be that are meant to be the same, where stations are
// `spacing_m` apart.
inline double place_tolerance_m(const Line& line, double spacing_m) {
  return kOffPlaceShare * spacing_m + rounding_m(line);
}

}  // namespace raywalk
