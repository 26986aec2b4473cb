// Reads the samples of a column and mixes them: the two stations around each acquisition point by
// nearness, and the lines by their shares.
//
// Per output row and station one sample: 12 bytes read in two places and some 30 operations. Lines
// in front and behind are mixed in registers where nothing is skipped and no gain changes; else
// each is added to sums of 8 bytes per row.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/view/column_distances.h"
#include "core/view/column_shares.h"
#include "core/view/row_readings.h"
#include "core/view/sample_reader.h"
#include "core/view/station_positions.h"
#include "core/view/view_inputs.h"

namespace raywalk {

class ColumnMixing {
 public:
  // For a view with distances. References must outlive the object.
  ColumnMixing(const ViewInputs& view, ColumnDistances& distances, StationPositions& positions,
               SampleReader& reader);

  // Mixes rows of a column into rgb bytes, its row 0 first. The byte beyond the rows is preserved.
  void mix(const ColumnPoints& points, std::span<const RaySource> sources,
           const ColumnShares& shares, RowRun rows, std::uint8_t* rgb);

  // Readings since the first column; samples are counted by the reader.
  const WorkCounts& work() const { return work_; }

 private:
  // A run of rows of the plain cut; the same station twice where only one is used.
  struct StoredRows {
    std::array<const std::uint8_t*, 2> columns{};
    std::array<int, 2> stations{};
    int count = 0;
    std::int16_t share = 0;  // of the second
  };

  bool mixes_in_registers(std::span<const RaySource> sources) const;
  void mix_in_registers(const ColumnPoints& points, std::span<const RaySource> sources,
                        const ColumnShares& shares, RowRun rows, std::uint8_t* rgb);
  void mix_source(const ColumnPoints& points, const RaySource& source,
                  std::span<const std::uint8_t> needed, double skip_px, RowRun rows,
                  std::uint8_t* rgb);
  void add_source(const ColumnPoints& points, const RaySource& source,
                  std::span<const std::uint8_t> needed, double skip_px,
                  std::span<const std::int16_t> weights, RowRun rows);
  void mix_piece(const ColumnPoints& points, const RaySource& source, const RowPiece& piece,
                 std::uint8_t* rgb);
  void add_piece(const ColumnPoints& points, const RaySource& source, const RowPiece& piece,
                 std::span<const std::int16_t> weights);
  RowSamples samples_of(const ColumnPoints& points, const RaySource& source, const RowPiece& piece);
  StoredRows stored_rows(int u, const RaySource& source, RowRun rows);
  // Writes the rows, mixed and multiplied by their gains.
  void mix_stored(int u, const RaySource& source, const StoredRows& stored, RowRun rows,
                  std::uint8_t* rgb);
  static std::array<StationShare, 2> shares_of(const RaySource& source, const StoredRows& stored);
  std::int64_t rows_with_weight(std::span<const std::int16_t> weights, RowRun rows) const;
  void count_readings(Reading reading, std::int64_t readings);

  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  ColumnDistances& distances_;
  StationPositions& positions_;
  SampleReader& reader_;
  RowReadings readings_;
  WorkCounts work_;
  std::vector<std::array<PositionArrays, 2>> samples_;  // of the two stations of each source
  std::vector<std::uint8_t> levels_;                    // stored rows before they are blended
  std::vector<std::int16_t> sum_, row_weight_;
  std::vector<std::uint8_t> needed_;
};

}  // namespace raywalk
