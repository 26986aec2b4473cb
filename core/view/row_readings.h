// Which rows of a source are read from which of its stations, and how, where the options allow to
// skip work that hardly moves a pixel (work_skipped.h); else all rows in the usual way.
//
// If something may be skipped, per row of the distances some 30 operations for each source.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/view/column_distances.h"
#include "core/view/row_pieces.h"
#include "core/view/station_positions.h"
#include "core/view/view_inputs.h"

namespace raywalk {

class RowReadings {
 public:
  // References must outlive the object.
  RowReadings(const ViewInputs& view, StationPositions& positions, const RowMapping& mapping);

  // Runs of `rows` in which a source is read, and how. `needed`: rows of the distances, not 0 where
  // the source is read at all. `skip_px` as in ColumnShares. Valid until the next call.
  std::span<const RowPiece> split(const ColumnPoints& points, const RaySource& source, RowRun rows,
                                  std::span<const std::uint8_t> needed, double skip_px);

 private:
  void choose(const ColumnPoints& points, const RaySource& source,
              std::span<const std::uint8_t> needed, double skip_px);
  void skip_second_station(const ColumnPoints& points, const RaySource& source, double skip_px);
  void skip_correction(const ColumnPoints& points, const RaySource& source, double skip_px);
  void keep_near(const ColumnPoints& points, ColumnOffset a, ColumnOffset b, double move_px);
  void read_near_rows(Reading reading);

  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  StationPositions& positions_;
  const RowMapping& mapping_;
  int rows_per_distance_;
  std::vector<RowPiece> pieces_;
  std::vector<Reading> readings_;   // [row of the distances], or [row] where each is computed
  std::vector<std::uint8_t> near_;  // the same
};

}  // namespace raywalk
