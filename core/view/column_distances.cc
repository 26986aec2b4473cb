#include "core/view/column_distances.h"

#include <cmath>

namespace raywalk {

ColumnDistances::ColumnDistances(const ViewInputs& view)
    : view_(view),
      kernels_(column_kernels()),
      rows_per_distance_(rows_per_distance(view)),
      mapping_(view.output.height, view.distances->size().height),
      latitudes_(view.output.height, view.output.height),
      depth_omega_(static_cast<size_t>(view.distances->size().height)),
      omega_(rows_per_distance_ > 1 ? 0 : static_cast<size_t>(view.output.height)),
      edges_(depth_omega_.size() + kShiftPadding) {}

const ColumnPoints& ColumnDistances::prepare(int u) {
  const DistanceView& distances = *view_.distances;
  const PanoramaSize size = distances.size();
  const double map_u = (u + 0.5) * size.width / view_.output.width - 0.5;
  const ColumnPosition position = split_column(map_u, size.width);
  kernels_.mix_omega(distances.column(position.whole),
                     distances.column((position.whole + 1) % size.width), position.part,
                     size.height, distances.surface_tolerance(), depth_omega_.data());
  if (rows_per_distance_ > 1) {
    kernels_.find_edges(depth_omega_.data(), size.height - 1, distances.surface_tolerance(),
                        edges_.data());
  } else {
    kernels_.upsample_omega(depth_omega_.data(), mapping_.upper.data(), mapping_.fraction.data(),
                            view_.output.height, distances.surface_tolerance(), omega_.data());
  }
  points_ = {.u = u,
             .theta_rad = angles_from_pixel({double(u), 0.0}, view_.output).theta_rad,
             .depth_theta = split_column(std::round(map_u), size.width).whole,
             .depth_omega = depth_omega_,
             .edges = edges_.data(),
             .omega = omega_};
  return points_;
}

ColumnPoints ColumnDistances::in_layers(const ColumnPoints& points, const RaySource& source) {
  if (!view_.layers) return points;
  snapped_omega_.assign(points.omega.begin(), points.omega.end());
  kernels_.snap_to_layers(latitudes_.table(), view_.output.height, view_.acquisition_point(source),
                          *view_.layers, snapped_omega_.data());
  ColumnPoints snapped = points;
  snapped.omega = snapped_omega_;
  return snapped;
}

}  // namespace raywalk
