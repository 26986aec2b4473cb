// Renders single columns of a view from the stations of its plan, step by step (view_inputs.h).
//
// initial: the vertical cut (initial_columns.h). hlf-vd: each pixel is read where the acquisition
// point saw the point that the viewpoint sees. two-sided: the same from the lines in front and
// behind, each where it sees the point, weighted by nearness.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/view/column_distances.h"
#include "core/view/column_mixing.h"
#include "core/view/column_shares.h"
#include "core/view/fill_stations.h"
#include "core/view/hidden_pixels.h"
#include "core/view/initial_columns.h"
#include "core/view/sample_reader.h"
#include "core/view/source_visibility.h"
#include "core/view/station_positions.h"
#include "core/view/view_inputs.h"

namespace raywalk {

// The rows outside the polar caps. In the caps, [0, begin) and [end, height), columns `step` (2 or
// 4) apart are less than a row's height apart: within 30 (step 2) or 14.4 degrees (step 4) of a
// pole. There the columns between two such columns can be their mean without visible loss.
RowRun rows_between_polar_caps(int height, int step);

// One per thread: it owns scratch memory and remembers the visibility of the last columns.
class ColumnRenderer {
 public:
  // `view` must outlive the object.
  explicit ColumnRenderer(const ViewInputs& view);
  ~ColumnRenderer();
  ColumnRenderer(const ColumnRenderer&) = delete;
  ColumnRenderer& operator=(const ColumnRenderer&) = delete;

  // Renders output column `u` from the given lines into height * 3 rgb bytes. Only the rows of
  // ViewInputs::rows are valid; one byte beyond is scratch. Without sources the column shows what
  // other stations see, else a grey pattern.
  void render(int u, std::span<const RaySource> sources, std::uint8_t* rgb);

  // The same, but in columns with more rows than their distances it may skip the polar caps outside
  // rows_between_polar_caps(height, step). It then returns true, and the caller fills them with the
  // mean of the columns step / 2 to both sides.
  bool render_sparsely(int u, std::span<const RaySource> sources, int step, std::uint8_t* rgb);

  // The rows of the last column that no station shows. What they hold, a neighbour's colour or the
  // grey pattern, stands in for what the rest of the picture tells (picture_fill.h).
  std::span<const RowRun> unknown_rows() const { return unknown_rows_; }

  PixelCounts counts() const;

 private:
  // The steps of depth-corrected views.
  struct Correction;

  void render_corrected(int u, std::span<const RaySource> sources, RowRun rows, std::uint8_t* rgb);
  // A column without sources: what other stations see of it.
  void render_unserved(int u, std::uint8_t* rgb);
  // A grey pattern.
  void fill_empty(int u, std::uint8_t* rgb);

  const ViewInputs& view_;
  SampleReader reader_;
  StationPositions positions_;
  InitialColumns initial_;
  std::unique_ptr<Correction> correction_;  // null in an initial view
  std::vector<RowRun> unknown_rows_;
  PixelCounts counts_;  // but for what the steps count
};

}  // namespace raywalk
