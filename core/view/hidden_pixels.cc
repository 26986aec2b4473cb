#include "core/view/hidden_pixels.h"

#include <algorithm>

#include "core/view/sample_check.h"

namespace raywalk {

HiddenPixels::HiddenPixels(const ViewInputs& view, const RowMapping& mapping,
                           StationPositions& positions, FillStations& fill, SampleReader& reader)
    : view_(view),
      mapping_(mapping),
      positions_(positions),
      fill_(fill),
      reader_(reader),
      samples_(view.output.height),
      shown_(3 * static_cast<size_t>(view.output.height) + 1) {}  // a byte beyond is scratch

std::span<const RowRun> HiddenPixels::fill(const ColumnPoints& points,
                                           std::span<const std::uint8_t> hidden,
                                           std::uint8_t* rgb) {
  hidden_ = hidden;
  unresolved_.clear();
  const auto depth_rows = static_cast<int>(hidden.size());
  const auto is_any_hidden = [&](int depth_row) {
    return hidden[static_cast<size_t>(depth_row)] != 0;
  };
  const auto fill_of = [&](int depth_row) { return fill_.of(points.depth_theta, depth_row); };
  for (int depth_row = 0; depth_row < depth_rows;) {
    if (!is_any_hidden(depth_row)) {
      ++depth_row;
      continue;
    }
    const int begin = mapping_.first_row[static_cast<size_t>(depth_row)];
    const int station = fill_of(depth_row);
    do {
      ++depth_row;
    } while (depth_row < depth_rows && is_any_hidden(depth_row) && fill_of(depth_row) == station);
    const int end = mapping_.first_row[static_cast<size_t>(depth_row)];
    if (begin == end) continue;
    if (station == FillStations::kNone) {
      leave_unresolved({begin, end});
    } else {
      show_station(points, station, {begin, end}, rgb);
    }
  }
  return unresolved_;
}

void HiddenPixels::show_station(const ColumnPoints& points, int fill, RowRun rows,
                                std::uint8_t* rgb) {
  const MapStation& map = view_.fill_maps[static_cast<size_t>(fill)];
  const StationSamples samples =
      positions_.find(points, map.line, map.station, rows, samples_.positions());
  reader_.mix({.line = map.line,
               .count = 1,
               .station = {map.station},
               .at = {samples},
               .rows = rows.end - rows.begin},
              shown_.data());
  const LineVolume& volume = view_.room.volume(map.line);
  const LeftOutPixels& left_out = view_.room.distances(map.line).left_out();
  const bool anything_moved = left_out.any(map.station);
  SampleCheck masks(volume, map.station);
  LeftOutCheck moved(left_out, volume, map.station);
  // What moved is shown where no other station sees the place.
  const auto shows_moved = [&](int row) {
    return fill_.is_left_out(map, points.depth_theta, mapping_.nearest[static_cast<size_t>(row)]);
  };
  for (int row = rows.begin; row < rows.end; ++row) {
    const int i = row - rows.begin;
    const std::int32_t left = samples.positions.offset_left[i];
    const std::int32_t right = samples.positions.offset_right[i];
    // A sample may be masked or left out where an interpolated distance differs from those of the
    // rows around.
    if ((volume.masked() && !masks.valid(left, right)) ||
        (anything_moved && !moved.valid(left, right) && !shows_moved(row))) {
      leave_unresolved({row, row + 1});
      continue;
    }
    const int part = hidden_part(row);
    const std::uint8_t* const shown = shown_.data() + 3 * i;
    for (int c = 0; c < 3; ++c) {
      std::uint8_t& held = rgb[3 * row + c];
      held = static_cast<std::uint8_t>(held + ((shown[c] - held) * part) / kSeen);
    }
    if (part > kSeen / 2) ++filled_;
  }
}

void HiddenPixels::leave_unresolved(RowRun rows) {
  for (int row = rows.begin; row < rows.end; ++row) {
    if (!is_hidden(row)) continue;
    if (!unresolved_.empty() && unresolved_.back().end == row) {
      unresolved_.back().end = row + 1;
    } else {
      unresolved_.push_back({row, row + 1});
    }
  }
}

bool HiddenPixels::stretch(const ColumnPoints& points, RowRun rendered,
                           const std::function<void(int row)>& render_row, std::uint8_t* rgb) {
  const int rows = view_.output.height;
  const auto omega = [&](int row) {
    return points.depth_omega[static_cast<size_t>(mapping_.nearest[static_cast<size_t>(row)])];
  };
  for (const RowRun& run : unresolved_) {
    const int above = run.begin - 1;
    const int below = run.end;
    const bool below_is_farther = below < rows && (above < 0 || omega(below) < omega(above));
    const int from = below_is_farther ? below : above;
    if (from < 0 && view_.room.masked()) return false;
    stretched_ += run.end - run.begin;
    if (from < 0) continue;
    if ((from < rendered.begin || from >= rendered.end) && !is_hidden(from)) render_row(from);
    for (int row = run.begin; row < run.end; ++row) std::copy_n(rgb + 3 * from, 3, rgb + 3 * row);
  }
  return true;
}

}  // namespace raywalk
