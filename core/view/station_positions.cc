#include "core/view/station_positions.h"

#include <algorithm>

namespace raywalk {

StationPositions::StationPositions(const ViewInputs& view)
    : view_(view),
      kernels_(column_kernels()),
      rows_per_distance_(raywalk::rows_per_distance(view)),
      latitudes_(view.output.height, view.output.height) {
  if (view.arithmetic == Arithmetic::kDouble) {
    precise_ = std::make_unique<PrecisePositions>(view.output.height);
  }
  if (view.distances == nullptr) {
    zero_omega_.resize(static_cast<size_t>(view.output.height));
    return;
  }
  const int depth_rows = view.distances->size().height;
  depth_latitudes_ = std::make_unique<LatitudeTable>(depth_rows, depth_rows);
  if (rows_per_distance_ == 1) return;
  const auto padded = static_cast<size_t>(depth_rows) + kShiftPadding;
  shift_u_.resize(padded);
  shift_v_.resize(padded);
  no_between_.resize(padded);
}

StationSamples StationPositions::find(const ColumnPoints& points, int line, int station,
                                      RowRun rows, SamplePositions into) {
  const int per_row = rows_per_distance_;
  if (per_row == 1) {
    const auto omega = points.omega.subspan(static_cast<size_t>(rows.begin),
                                            static_cast<size_t>(rows.end - rows.begin));
    return find_each(points.theta_rad, omega, line, station, rows.begin, into);
  }
  // A row's position is interpolated between those of the distances' rows around it.
  const int depth_rows = view_.distances->size().height;
  const auto row_above = [&](int row) { return std::max(row - per_row / 2, 0) / per_row; };
  const int first = row_above(rows.begin);
  const int count = std::min(row_above(rows.end - 1) + 2, depth_rows) - first;
  ColumnTarget target = target_of(points.theta_rad);
  target.rays = layout_of(view_, line);
  kernels_.find_shifts(depth_latitudes_->table(first), points.depth_omega.data() + first, first,
                       count, depth_rows, offset_from(line, station, points.theta_rad), target,
                       shift_u_.data(), shift_v_.data());
  kernels_.add_jumps(shift_u_.data(), shift_v_.data(), count - 1, target, points.edges + first,
                     no_between_.data());
  const ShiftedRows shifted{.u = shift_u_.data(),
                            .v = shift_v_.data(),
                            .no_between = no_between_.data(),
                            .first = first,
                            .rows = depth_rows,
                            .per_row = per_row};
  kernels_.place_shifted(shifted, rows.begin, rows.end, target, into);
  return samples_at(line, station, into);
}

StationSamples StationPositions::find_cut(int u, int line, int station, SamplePositions into) {
  const double theta_rad = angles_from_pixel({double(u), 0.0}, view_.output).theta_rad;
  return find_each(theta_rad, zero_omega_, line, station, 0, into);
}

StationSamples StationPositions::find_each(double theta_rad, std::span<const float> omega, int line,
                                           int station, int first_row, SamplePositions into) {
  if (precise_) {
    precise_->find(first_row, omega, displacement_from(line, station, theta_rad), theta_rad,
                   view_.room.panorama(), into);
  } else {
    kernels_.find_samples(latitudes_.table(first_row), omega.data(), static_cast<int>(omega.size()),
                          offset_from(line, station, theta_rad), target_of(theta_rad), into);
  }
  return samples_at(line, station, into);
}

StationSamples StationPositions::samples_at(int line, int station,
                                            SamplePositions positions) const {
  const LineVolume& volume = view_.room.volume(line);
  const std::int32_t column_bytes = 3 * volume.panorama().height;
  return {volume.rays(station), positions, {column_bytes, column_bytes * volume.panorama().width}};
}

ColumnTarget StationPositions::target_of(double theta_rad) const {
  const PanoramaSize captured = view_.room.panorama();
  const ColumnPosition position =
      split_column(pixel_from_angles({theta_rad, 0.0}, captured).u, captured.width);
  return {captured.width, captured.height, position.whole, position.part};
}

Eigen::Vector3d StationPositions::displacement_from(int line, int station, double theta_rad) const {
  const Line& geometry = view_.room.grid().lines[static_cast<size_t>(line)];
  return view_.eye_m(theta_rad) - geometry.stations[static_cast<size_t>(station)].position_m;
}

ColumnOffset StationPositions::offset_from(int line, int station, double theta_rad) const {
  return column_offset(displacement_from(line, station, theta_rad), theta_rad);
}

ColumnOffset StationPositions::acquisition_offset(const RaySource& source, double theta_rad) const {
  const ColumnOffset a = offset_from(source.line, source.station, theta_rad);
  const ColumnOffset b = offset_from(source.line, source.station + 1, theta_rad);
  const auto between = [&](float from, float to) {
    return from + (to - from) * static_cast<float>(source.fraction);
  };
  return {between(a.forward, b.forward), between(a.up, b.up), between(a.side, b.side)};
}

}  // namespace raywalk
