// Columns of initial views: the vertical cut, the pixels (theta, phi) of the panoramas around the
// acquisition points, interpolated. Without distances masked rows cannot be read from where another
// line shows the point: the valid rows of the column are stretched instead.
//
// Where output columns coincide with captured columns, 3 bytes read in sequence per row and station
// and 2 operations per channel; else one sample each.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/view/sample_reader.h"
#include "core/view/station_positions.h"
#include "core/view/view_inputs.h"

namespace raywalk {

class InitialColumns {
 public:
  // References must outlive the object.
  InitialColumns(const ViewInputs& view, StationPositions& positions, SampleReader& reader);

  // Renders output column `u` from its sources, at least one. Returns the rows that are stretched,
  // at the ends of the column; all of them, without rendering any, where no row is valid.
  std::vector<RowRun> render(int u, std::span<const RaySource> sources, std::uint8_t* rgb);

  // Rows stretched since the first column.
  std::int64_t stretched() const { return stretched_; }

 private:
  // The share of the station before (0) or after (1) the acquisition point, 1 in all.
  double station_share(const RaySource& source, int next) const;
  // Output columns that coincide with captured columns: mixed without resampling.
  void mix_stored_columns(int u, std::span<const RaySource> sources, std::uint8_t* rgb);
  void render_cut(int u, std::span<const RaySource> sources, std::uint8_t* rgb);
  // Valid rows of the columns of a station that are read.
  RowRun valid_rows(int u, int line, int station) const;

  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  StationPositions& positions_;
  SampleReader& reader_;
  std::array<PositionArrays, 2> samples_;
  std::vector<std::int16_t> sum_, row_weight_;
  std::int64_t stretched_ = 0;
};

}  // namespace raywalk
