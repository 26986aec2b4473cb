// Which points of a column an acquisition point sees.
// The viewpoint P, the acquisition point A and everything column theta shows lie in one vertical
// plane, whatever their heights, so that occlusion is decided on one great circle: the points that
// P sees are projected onto the circle around A, and the nearest in each direction is visible.
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

  // visible[row] = 1 where A, in the plane of column `theta`, sees what the viewpoint sees in that
  // row.
  void compute(const DistanceView& distances, int theta, AcquisitionPoint from,
               std::vector<std::uint8_t>& visible);

 private:
  void find_bins(float tolerance);
  void keep_nearest();
  void fill_gap(std::size_t i, std::size_t before);

  int rows_;
  LatitudeTable ring_latitudes_;
  int points_ = 0;  // down the column, and up the opposite one where it matters
  // Of each point, as ColumnKernels::project_ring has them; bin_: the nearest row around A.
  std::vector<float> omega_, position_, omega_from_line_;
  std::vector<std::int32_t> bin_;
  std::vector<std::uint8_t> leaves_gap_;  // between it and the point before, on the same surface
  std::vector<float> nearest_;            // of each bin, between two more
};

}  // namespace raywalk
