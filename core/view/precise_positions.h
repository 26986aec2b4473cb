// Where a station saw the points of a column, in double precision: the positions of
// Arithmetic::kDouble and the reference of the float kernels. Input are the inverse distances in
// float.
// The C library's atan2 is accurate to an ulp but not bit-identical on every processor: positions,
// rounded to 1/32768 pixel, may rarely differ by one such step between machines.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/view/column_kernels.h"
#include "core/view/row_table.h"

namespace raywalk {

class PrecisePositions {
 public:
  // For columns of `rows` rows.
  explicit PrecisePositions(int rows);

  // As ColumnKernels::find_samples: where a station at `displacement_m` (viewpoint - station, world
  // frame) saw the points of the column that looks along `theta_rad`, for the rows from `first_row`
  // on that `omega` has values for, in panoramas of the size `captured`.
  void find(int first_row, std::span<const float> omega, const Eigen::Vector3d& displacement_m,
            double theta_rad, PanoramaSize captured, SamplePositions positions) const;

  // One row's position before rounding: columns to the right of the column's plan direction in the
  // panorama, and rows from the top, which may reach half a row over a pole.
  PixelPosition seen_at(int row, double omega, const PreciseOffset& offset,
                        PanoramaSize captured) const;

 private:
  std::vector<double> sin_phi_;
  std::vector<double> cos_phi_;
};

}  // namespace raywalk
