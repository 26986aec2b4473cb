// Where in a station's panorama the points of a column are read.
//
// Equation (5) of the paper on the whole great circle, solved for the source: a point at inverse
// distance omega in direction r from the viewpoint is seen from a station in direction r + omega
// (viewpoint - station), which needs no special case at infinity. Computed for each of the two
// stations around an acquisition point separately, so that near objects do not ghost.
//
// Per row of the distances some 40 operations, per output row some 25 and 16 bytes written.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/view/column_arrays.h"
#include "core/view/column_distances.h"
#include "core/view/precise_positions.h"
#include "core/view/row_table.h"
#include "core/view/view_inputs.h"

namespace raywalk {

class StationPositions {
 public:
  // `view` must outlive the object.
  explicit StationPositions(const ViewInputs& view);

  // The samples of output rows of a column in a station. `into` takes one position per row, as
  // SamplePositions has them.
  StationSamples find(const ColumnPoints& points, int line, int station, RowRun rows,
                      SamplePositions into);
  // The same of the plain cut, where everything is infinitely far: all rows of column `u`.
  StationSamples find_cut(int u, int line, int station, SamplePositions into);

  // From a station to the eye of the column at theta, in that column's frame.
  ColumnOffset offset_from(int line, int station, double theta_rad) const;
  // From the acquisition point of a source to that eye.
  ColumnOffset acquisition_offset(const RaySource& source, double theta_rad) const;
  // The position of a column's plan direction in a captured panorama.
  ColumnTarget target_of(double theta_rad) const;

  // Whether rows of the distances are further apart than output rows, and their latitudes.
  int rows_per_distance() const { return rows_per_distance_; }
  RowTable latitudes() const { return latitudes_.table(); }
  RowTable depth_latitudes() const { return depth_latitudes_->table(); }

 private:
  StationSamples find_each(double theta_rad, std::span<const float> omega, int line, int station,
                           int first_row, SamplePositions into);
  StationSamples samples_at(int line, int station, SamplePositions positions) const;
  Eigen::Vector3d displacement_from(int line, int station, double theta_rad) const;

  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  int rows_per_distance_;
  LatitudeTable latitudes_;
  std::unique_ptr<LatitudeTable> depth_latitudes_;  // null in an initial view
  std::unique_ptr<PrecisePositions> precise_;       // null unless positions are computed in double
  std::vector<float> zero_omega_;
  // As ShiftedRows has them.
  std::vector<float> shift_u_, shift_v_;
  std::vector<std::int32_t> no_between_;
};

}  // namespace raywalk
