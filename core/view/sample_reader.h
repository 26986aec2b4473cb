// Reads samples of stations with a view's interpolation, and counts them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/room/room.h"
#include "core/view/column_kernels.h"
#include "core/view/gain_rows.h"
#include "core/view/tile_requests.h"
#include "core/view/touched_rays.h"
#include "core/view/view_options.h"

namespace raywalk {

// Full weight of the kernels' fixed point.
inline constexpr int kWeightOne = 32767;
std::int16_t fixed_weight(double weight);

// The fastest kernels for an interpolation method.
const SampleReaders& readers_of(Interpolation interpolation);

// Sample positions of consecutive rows of a column, in one station or in two neighbours that are
// mixed.
struct RowSamples {
  int line = -1;
  int count = 0;  // of stations
  std::array<int, 2> station{};
  std::array<StationSamples, 2> at{};
  std::int16_t share = 0;  // of the second station, in 1/32768
  int rows = 0;
};

class SampleReader {
 public:
  // `touched` and `gains` may be null. References must outlive the reader.
  SampleReader(const Room& room, Interpolation interpolation, TouchedRays* touched,
               const RoomGains* gains = nullptr);

  // Writes rows * 3 bytes. The byte after them must be writable and is preserved.
  void mix(const RowSamples& samples, std::uint8_t* rgb);
  // Adds weight / 32768 of each row to sums as ColumnKernels::accumulate_pair has them.
  void accumulate(const RowSamples& samples, const std::int16_t* weight, std::int16_t* sum);
  // What mix() and accumulate() ask for; whoever reads samples without them has to ask.
  TileRequests& tiles() { return tiles_; }
  // Of the stations, which mix() and accumulate() apply; stored columns are left to the caller.
  GainRows& gains() { return gains_; }
  // Counts rows of a station's column, from `first_row` on, that are read uncorrected.
  void count_stored(int line, const std::uint8_t* first_row, int rows);

  // Counts samples at computed positions that were read without mix() and accumulate().
  void count_found(std::int64_t samples) { found_ += samples; }
  bool counts_bytes() const { return touched_ != nullptr; }

  // Number of samples read at computed positions, and of those read from stored columns.
  std::int64_t found() const { return found_; }
  std::int64_t stored() const { return stored_; }

 private:
  void ask_for_tiles(const RowSamples& samples);
  // Calls read(kernels, begin, end) for runs of rows read with the same kernels: cubic samples
  // whose 4 x 4 pixels are not all valid are read linearly.
  template <typename Read>
  void in_runs(const RowSamples& samples, Read read);
  void mix_levels(const RowSamples& samples, std::uint8_t* rgb);
  // `weight` null: all rows are read.
  void count(const RowSamples& samples, const std::int16_t* weight);
  void touch(const RowSamples& samples, Interpolation interpolation, int begin, int end,
             const std::int16_t* weight);

  const Room& room_;
  Interpolation interpolation_;
  const SampleReaders& readers_;
  const SampleReaders& linear_;
  TileRequests tiles_;
  GainRows gains_;
  std::vector<std::uint8_t> levels_;  // rows mixed before they are multiplied by gains
  TouchedRays* touched_;
  std::int64_t found_ = 0;
  std::int64_t stored_ = 0;
};

}  // namespace raywalk
