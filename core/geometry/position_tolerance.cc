#include "core/geometry/position_tolerance.h"

namespace raywalk {

double largest_coordinate_m(const Line& line) {
  const double length_m = std::max(std::abs(line.first_m()), std::abs(line.last_m()));
  return largest_coordinate_m(line.origin) + length_m;
}

}  // namespace raywalk
