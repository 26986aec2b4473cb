// The distances of an output column: those of the distance view, interpolated between its columns.
//
// Per row of the distances: 8 bytes read and some 10 operations, and 4 operations for its edge.
// Where every output row's position is computed, 4 bytes written and 8 operations for each.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/view/column_arrays.h"
#include "core/view/row_table.h"
#include "core/view/view_inputs.h"

namespace raywalk {

// The points that an output column shows. Inverse distances from the viewpoint, 1/m.
struct ColumnPoints {
  int u = 0;                            // the output column
  double theta_rad = 0.0;               // its plan direction
  int depth_theta = 0;                  // the nearest column of the distance view
  std::span<const float> depth_omega;   // [row of the distances]
  const std::int32_t* edges = nullptr;  // as ColumnKernels::find_edges has them
  std::span<const float> omega;         // [output row]; empty where positions are interpolated
};

class ColumnDistances {
 public:
  // For a view with distances, which must outlive the object.
  explicit ColumnDistances(const ViewInputs& view);

  // The points of output column `u`. Valid until the next call.
  const ColumnPoints& prepare(int u);
  // The points of a column, moved onto the depth layers around the acquisition point of a source,
  // if the view has layers. Valid until the next call of either.
  ColumnPoints in_layers(const ColumnPoints& points, const RaySource& source);

  // Rows of the output and of the distances.
  const RowMapping& mapping() const { return mapping_; }

 private:
  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  int rows_per_distance_;
  RowMapping mapping_;
  LatitudeTable latitudes_;
  std::vector<float> depth_omega_, omega_, snapped_omega_;
  std::vector<std::int32_t> edges_;
  ColumnPoints points_;
};

}  // namespace raywalk
