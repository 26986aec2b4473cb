// Which points of a column an acquisition point sees.
// The viewpoint P, the acquisition point A and everything column theta shows lie in one vertical
// plane, so that occlusion is decided on one great circle: the points that P sees are projected
// onto the circle around A, and the nearest in each direction is visible.
#pragma once

#include <cstdint>
#include <vector>

#include "core/view/distance_view.h"
#include "core/view/row_table.h"

namespace raywalk {

class RingVisibility {
 public:
  // For distance views of `rows` rows.
  explicit RingVisibility(int rows);

  // visible[row] = 1 where A, at signed plan distance d_p along column `theta`, sees what the
  // viewpoint sees in that row.
  void compute(const DistanceView& distances, int theta, double d_p_m,
               std::vector<std::uint8_t>& visible);

 private:
  int rows_;
  LatitudeTable ring_latitudes_;
  std::vector<float> omega_, position_, omega_from_line_, nearest_;
};

}  // namespace raywalk
