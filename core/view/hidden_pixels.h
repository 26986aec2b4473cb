// Fills what no line sees of a column: from other stations, or stretched. What no station sees is
// stretched, the farther neighbour in the column, until the finished picture is filled
// (picture_fill.h).
//
// Per hidden row one sample, besides the search for a station (fill_stations.h).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/view/column_distances.h"
#include "core/view/fill_stations.h"
#include "core/view/sample_reader.h"
#include "core/view/station_positions.h"
#include "core/view/view_inputs.h"

namespace raywalk {

class HiddenPixels {
 public:
  // For a view with distances. References must outlive the object.
  HiddenPixels(const ViewInputs& view, const RowMapping& mapping, StationPositions& positions,
               FillStations& fill, SampleReader& reader);

  // Shows other stations in the hidden rows of a column, each as far as it is hidden (0 to kSeen,
  // for each row of the distances). Returns the rows that nothing else is shown in.
  std::span<const RowRun> fill(const ColumnPoints& points, std::span<const std::uint8_t> hidden,
                               std::uint8_t* rgb);

  // Gives the rows that fill() returned the colour of the farther of their neighbours. A neighbour
  // outside the rendered rows that a line sees is rendered by `render_row` first. Returns false
  // where nothing in the column is shown at all.
  bool stretch(const ColumnPoints& points, RowRun rendered,
               const std::function<void(int row)>& render_row, std::uint8_t* rgb);

  // Since the first column.
  std::int64_t filled() const { return filled_; }
  std::int64_t stretched() const { return stretched_; }

 private:
  // Shows a station in hidden rows of the output.
  void show_station(const ColumnPoints& points, int fill, RowRun rows, std::uint8_t* rgb);
  // Marks those of the rows that nothing else is shown in.
  void leave_unresolved(RowRun rows);
  // Of an output row, what no line sees, 0 to kSeen, and whether that is all of it.
  std::uint8_t hidden_part(int row) const {
    return hidden_[static_cast<std::size_t>(mapping_.nearest[static_cast<std::size_t>(row)])];
  }
  bool is_hidden(int row) const { return hidden_part(row) == kSeen; }

  const ViewInputs& view_;
  const RowMapping& mapping_;
  StationPositions& positions_;
  FillStations& fill_;
  SampleReader& reader_;
  std::span<const std::uint8_t> hidden_;  // of the column
  std::vector<RowRun> unresolved_;        // of the column
  PositionArrays samples_;
  std::vector<std::uint8_t> shown_;  // rgb of a run of hidden rows
  std::int64_t filled_ = 0;
  std::int64_t stretched_ = 0;
};

}  // namespace raywalk
