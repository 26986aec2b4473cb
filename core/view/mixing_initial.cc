#include <algorithm>
#include <cmath>

#include "core/view/mixing_scratch.h"

namespace raywalk {

// Columns of a view of the captured size are columns of the stations, if nothing changes them.
bool StationMixing::shows_stored_columns() const {
  return view_.output == view_.room.panorama() && !view_.room.masked() && view_.exposure == nullptr;
}

// Every row is read in the same direction in each station.
void StationMixing::place_cut(const Column& column, RowRun rows, Placed* placed) {
  placed->count = 0;
  const PanoramaSize captured = view_.room.panorama();
  const int count = rows.end - rows.begin;
  for (const Read& read : column.reads) {
    PlacedStation& station = placed->add(read);
    for (int i = 0; i < count; ++i) {
      const double row = (rows.begin + i + 0.5) * captured.height / view_.output.height - 0.5;
      station.v[static_cast<std::size_t>(i)] = static_cast<float>(row);
    }
    station.u.fill(0.0f);
    scratch_->row_weight.fill(read.share.reliable);
    finish(column.captured, scratch_->row_weight.data(), count, &station);
  }
}

void StationMixing::mix_stored(const Column& column, RowRun rows, std::uint8_t* bgr) {
  const std::size_t bytes = 3 * static_cast<std::size_t>(rows.end - rows.begin);
  std::array<WeightedColumn, 2 * kMaxSources> columns;
  float share = 0.0f;
  int weights = 0;
  for (std::size_t k = 0; k < column.reads.size(); ++k) {
    const Read& read = column.reads[k];
    share += read.share.reliable;
    const auto weight = static_cast<int>(std::lround(share * kColumnsOne)) - weights;
    weights += weight;
    columns[k] = {.rgb = view_.room.volume(read.line).column(read.station, column.u).data() +
                         static_cast<std::ptrdiff_t>(3 * rows.begin),
                  .next = 3 * view_.output.height,
                  .weight = static_cast<std::uint16_t>(weight)};
  }
  std::array<std::uint8_t, 3 * kRows + 1> mixed;
  mix_columns(std::span(columns).first(column.reads.size()), static_cast<int>(bytes), mixed.data());
  store_column(mixed.data(), rows.end - rows.begin, bgr, kStride);
}

}  // namespace raywalk
