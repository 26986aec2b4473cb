// The share of each line in each row of a column, and what none of them sees.
//
// Lines are weighted by nearness, so that the picture is continuous when the viewpoint crosses a
// line, and where they see a point. Where the distances cannot be relied on, a line is not left out
// because it does not seem to see a point.
//
// Per row of the distances some 10 operations for each line.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/view/source_visibility.h"
#include "core/view/view_inputs.h"

namespace raywalk {

// All of rows of the distances. Of a single source there are no weights.
struct ColumnShares {
  std::array<std::vector<std::int16_t>, kMaxSources> weights;  // in 1/32768, of each source
  std::vector<std::uint8_t> needed;  // of a single source: not 0 where it is read
  std::vector<std::uint8_t> hidden;  // what no source sees of a row, 0 to kSeen
  bool any_hidden = false;
  bool any_shared = true;  // whether any row is blended from several sources
  double skip_px = 0.0;    // the part of ViewInputs::skip_px left for reading it (work_skipped.h)
};

class ColumnWeights {
 public:
  // For a view with distances. References must outlive the object.
  ColumnWeights(const ViewInputs& view, SourceVisibility& visibility, StationPositions& positions,
                const RowMapping& mapping);

  // The shares of a column's sources, at least one. Valid until the next call.
  const ColumnShares& weigh(const ColumnPoints& points, std::span<const RaySource> sources);
  // Those of a column that no line serves.
  const ColumnShares& weigh_none();

  // Pixels read from one side of the viewpoint though both see them, since the first column.
  std::int64_t one_side() const { return one_side_; }

 private:
  using Visible = std::array<std::span<const std::uint8_t>, kMaxSources>;

  // The rows that each source sees, without those that the options skip.
  void find_visible_rows(const ColumnPoints& points, std::span<const RaySource> sources,
                         Visible& visible);
  void read_second_side_where_hidden(const ColumnPoints& points, std::span<const RaySource> sources,
                                     Visible& visible);
  void skip_second_side(const ColumnPoints& points, std::span<const RaySource> sources,
                        Visible& visible);
  // From how well the best source sees each row.
  void find_hidden(std::span<const std::uint8_t> seen);
  int output_rows_of(std::size_t depth_row) const;

  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  SourceVisibility& visibility_;
  StationPositions& positions_;
  const RowMapping& mapping_;
  ColumnShares shares_;
  std::int64_t one_side_ = 0;
  std::vector<std::uint8_t> most_, seeing_;  // as ColumnKernels::weigh_rows has them
  std::vector<float> weight_scale_;
  std::array<std::vector<std::uint8_t>, kMaxSources> unskipped_;  // of the visible rows
  std::vector<std::uint8_t> near_, dropped_;
};

}  // namespace raywalk
