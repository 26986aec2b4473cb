#include <algorithm>

#include "core/view/mask_check.h"
#include "core/view/mixing_scratch.h"

namespace raywalk {
namespace {

// Where an output row is shown from, if not a station of FillStations.
constexpr int kNowhere = -1, kItsLines = -2;

}  // namespace

void StationMixing::fill_rows(const Column& column, RowRun rows, const float* total,
                              std::uint8_t* bgr) {
  const bool empty = column.sources.count == 0;
  if (view_.is_initial()) return leave_masked(column, rows, total, bgr);
  if (!empty && !column.any_masks && !view_.visibility.any_filled(column.nearest)) return;
  const auto& nearest = view_.rows.nearest;
  const std::uint8_t* const fill = view_.visibility.fill(column.nearest);
  const int last = nearest[static_cast<std::size_t>(rows.end - 1)];
  const auto show = [&](int station, RowRun run) {
    if (station == kNowhere) leave_unread(column, run, bgr + (run.begin - rows.begin) * kStride);
    if (station >= 0) show_station(column, station, run, bgr + (run.begin - rows.begin) * kStride);
    if (empty) counts_.empty += run.end - run.begin;
  };
  RowRun run{rows.begin, rows.begin};  // of rows shown from one place
  int shown = kItsLines;
  for (int row = rows.begin; row < rows.end;) {
    const int distance_row = nearest[static_cast<std::size_t>(row)];
    // Masks end anywhere; otherwise the rows of a pixel of the distances are alike, as are all that
    // are not filled.
    int end = row + 1, station = kItsLines;
    if (column.any_masks || empty || fill[distance_row] != 0) {
      station = station_to_show(column, row, total + (row - rows.begin));
      if (!column.any_masks) end = view_.rows.first[static_cast<std::size_t>(distance_row) + 1];
    } else {
      const std::uint8_t* const next = std::find_if(fill + distance_row, fill + last + 1,
                                                    [](std::uint8_t by) { return by != 0; });
      end = view_.rows.first[static_cast<std::size_t>(next - fill)];
    }
    end = std::min(end, rows.end);
    if (station != shown) {
      show(shown, run);
      run.begin = row;
      shown = station;
    }
    run.end = row = end;
  }
  show(shown, run);
}

// Of an initial view.
void StationMixing::leave_masked(const Column& column, RowRun rows, const float* total,
                                 std::uint8_t* bgr) {
  const bool empty = column.reads.empty();
  if (empty) counts_.empty += rows.end - rows.begin;
  if (!empty && !column.any_masks) return;
  for (int row = rows.begin; row < rows.end; ++row) {
    const int i = row - rows.begin;
    if (empty || total[i] == 0.0f) leave_unread(column, {row, row + 1}, bgr + i * kStride);
  }
}

// Nothing of what must not be used stays in the picture, even if nothing can be filled in.
void StationMixing::leave_unread(const Column& column, RowRun rows, std::uint8_t* bgr) {
  unread_.push_back({column.u, rows});
  for (int i = 0; i < rows.end - rows.begin; ++i)
    std::fill_n(bgr + i * kStride, 3, std::uint8_t{0});
}

// The station of a row; `total`: of its weights, where stations have masks.
int StationMixing::station_to_show(const Column& column, int row, const float* total) {
  const int distance_row = view_.rows.nearest[static_cast<std::size_t>(row)];
  const std::uint8_t fill = view_.visibility.fill(column.nearest)[distance_row];
  if (fill == kNoStation) return kNowhere;
  if (fill != 0 && fill != kReadUnseen) return fill - 1;
  if (!column.any_masks || *total > 0.0f) return kItsLines;
  const int station =
      view_.fill.find(view_.distances, point_in(view_.distances, column.nearest, distance_row));
  return station == FillStations::kNone ? kNowhere : station;
}

void StationMixing::show_station(const Column& column, int station, RowRun rows,
                                 std::uint8_t* bgr) {
  Scratch& s = *scratch_;
  const MapStation& map = view_.fill.station(station);
  const Read read{.line = map.line,
                  .station = map.station,
                  .has_masks = has_masks(view_.room, map.line, map.station)};
  const int count = rows.end - rows.begin;
  const auto first = static_cast<std::size_t>(rows.begin);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    s.point_inverse[i] = view_.distances.column(column.nearest)[view_.rows.nearest[first + i]];
  }
  s.points.count = 0;
  s.row_weight.fill(1.0f);
  place_points({.theta_rad = column.theta_rad,
                .eye_m = column.eye_m,
                .captured = column.captured,
                .count = count,
                .sin_phi = view_.latitudes.sin_phi.data() + first,
                .cos_phi = view_.latitudes.cos_phi.data() + first,
                .inverse = s.point_inverse.data()},
               s.row_weight.data(), read, &s.points);
  mix(false, count, &s.points, nullptr, bgr, kStride);
  counts_.filled += count;
  if (!read.has_masks) return;
  // A sample may be masked where its distance differs from those around. What moved is shown where
  // no other station sees the place.
  const int beyond = view_.options.interpolation == Interpolation::kCubic ? 1 : 0;
  MaskCheck check(view_.room, read.line, read.station, beyond);
  for (int row = rows.begin; row < rows.end; ++row) {
    const auto i = static_cast<std::size_t>(row - rows.begin);
    const std::int32_t left = s.points.stations[0].left[i], right = s.points.stations[0].right[i];
    if (check.usable(left, right)) continue;
    const ViewPoint point =
        point_in(view_.distances, column.nearest, view_.rows.nearest[first + i]);
    if (check.valid(left, right) && view_.fill.is_left_out(map, point)) continue;
    leave_unread(column, {row, row + 1}, bgr + (row - rows.begin) * kStride);
    --counts_.filled;
  }
}

}  // namespace raywalk
