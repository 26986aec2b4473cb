#include "core/view/row_readings.h"

#include <algorithm>

#include "core/view/source_visibility.h"
#include "core/view/work_skipped.h"

namespace raywalk {

RowReadings::RowReadings(const ViewInputs& view, StationPositions& positions,
                         const RowMapping& mapping)
    : view_(view),
      kernels_(column_kernels()),
      positions_(positions),
      mapping_(mapping),
      rows_per_distance_(positions.rows_per_distance()) {}

std::span<const RowPiece> RowReadings::split(const ColumnPoints& points, const RaySource& source,
                                             RowRun rows, std::span<const std::uint8_t> needed,
                                             double skip_px) {
  pieces_.clear();
  if (!skips_rows(view_)) {
    pieces_.push_back({rows, usual_reading(view_, source)});
    return pieces_;
  }
  choose(points, source, needed, skip_px);
  for (size_t begin = 0; begin < readings_.size();) {
    size_t end = begin + 1;
    while (end < readings_.size() && readings_[end] == readings_[begin]) ++end;
    const RowRun run = common_rows(
        {static_cast<int>(begin) * rows_per_distance_, static_cast<int>(end) * rows_per_distance_},
        rows);
    if (readings_[begin] != Reading::kNothing && !run.empty()) {
      pieces_.push_back({run, readings_[begin]});
    }
    begin = end;
  }
  return pieces_;
}

void RowReadings::choose(const ColumnPoints& points, const RaySource& source,
                         std::span<const std::uint8_t> needed, double skip_px) {
  const bool at_distances = rows_per_distance_ > 1;
  readings_.assign(at_distances ? points.depth_omega.size() : points.omega.size(),
                   usual_reading(view_, source));
  if (view_.skip_px > 0.0) {
    skip_second_station(points, source, skip_px);
    skip_correction(points, source, skip_px);
  }
  const auto& first_row = mapping_.first_row;
  for (size_t row = 0; row < needed.size(); ++row) {
    if (needed[row] != 0) continue;
    const auto begin = at_distances ? row : static_cast<size_t>(first_row[row]);
    const auto end = at_distances ? row + 1 : static_cast<size_t>(first_row[row + 1]);
    std::fill(readings_.begin() + static_cast<std::ptrdiff_t>(begin),
              readings_.begin() + static_cast<std::ptrdiff_t>(end), Reading::kNothing);
  }
}

void RowReadings::skip_second_station(const ColumnPoints& points, const RaySource& source,
                                      double skip_px) {
  if (usual_reading(view_, source) != Reading::kBoth) return;
  const double share = std::min(source.fraction, 1.0 - source.fraction);
  near_.assign(readings_.size(), 1);
  keep_near(points, positions_.offset_from(source.line, source.station, points.theta_rad),
            positions_.offset_from(source.line, source.station + 1, points.theta_rad),
            skip_px / share);
  read_near_rows(nearer_station(source));
}

void RowReadings::skip_correction(const ColumnPoints& points, const RaySource& source,
                                  double skip_px) {
  // Stored columns can be mixed only where output columns coincide with captured columns.
  if (view_.output != view_.room.panorama()) return;
  near_.assign(readings_.size(), 1);
  RowRun valid{0, view_.output.height};
  for (int next = 0; next < 2; ++next) {
    if (!reads(usual_reading(view_, source), next)) continue;
    const int station = source.station + next;
    keep_near(points, {}, positions_.offset_from(source.line, station, points.theta_rad), skip_px);
    valid = common_rows(valid, view_.room.volume(source.line).valid_rows(station, points.u));
  }
  const int per_row = rows_per_distance_;
  const bool all_valid = valid == RowRun{0, view_.output.height};
  for (size_t row = 0; row < near_.size() && !all_valid; ++row) {
    const int first = static_cast<int>(row) * per_row;
    if (first < valid.begin || first + per_row > valid.end) near_[row] = 0;
  }
  read_near_rows(Reading::kStored);
}

void RowReadings::keep_near(const ColumnPoints& points, ColumnOffset a, ColumnOffset b,
                            double move_px) {
  const MoveLimit limit = move_limit(move_px, view_.room.panorama());
  const auto rows = static_cast<int>(near_.size());
  if (rows_per_distance_ > 1) {
    kernels_.keep_near(positions_.depth_latitudes(), points.depth_omega.data(), rows, a, b, limit,
                       near_.data());
  } else {
    kernels_.keep_near(positions_.latitudes(), points.omega.data(), rows, a, b, limit,
                       near_.data());
  }
}

void RowReadings::read_near_rows(Reading reading) {
  if (!any_is(near_, 1)) return;
  if (rows_per_distance_ > 1) keep_with_neighbours(&near_);
  // Branchless, so that the compiler vectorises it.
  std::ranges::transform(
      readings_, near_, readings_.begin(),
      [=](Reading read, std::uint8_t is_near) { return is_near != 0 ? reading : read; });
}

}  // namespace raywalk
