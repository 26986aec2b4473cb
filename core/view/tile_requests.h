// Asks for the tiles of compressed lines that samples are about to be read from
// (LineVolume::require). Lines that are not compressed need nothing.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/room/room.h"
#include "core/view/column_kernels.h"
#include "core/view/view_options.h"

namespace raywalk {

// Which rows of a column are read: all, or those whose weight is not 0.
struct RowsRead {
  const std::int16_t* weight = nullptr;  // null: all rows
  int first_row = 0;                     // of the column; row i has weight[i / rows_per_weight]
  int rows_per_weight = 1;
};

class TileRequests {
 public:
  // `room` must outlive this.
  TileRequests(const Room& room, Interpolation interpolation)
      : room_(room), cubic_(interpolation == Interpolation::kCubic) {}

  // Asks for what `rows` samples at positions in a station read. Throws as LineVolume::require.
  void ask(int line, int station, const SamplePositions& at, int rows, RowsRead read = {}) {
    const LineVolume& volume = room_.volume(line);
    if (volume.form().compressed()) ask(volume, station, at, rows, read);
  }

 private:
  void ask(const LineVolume& volume, int station, const SamplePositions& at, int rows,
           RowsRead read);
  // For samples whose left (or right) pixels lie at offsets from `least` to `most`.
  void ask_between(const LineVolume& volume, int station, int side, std::int32_t least,
                   std::int32_t most);
  // The same with the columns around that cubic samples read too.
  void ask_for_cubic(const LineVolume& volume, int station, int side, std::int32_t least,
                     std::int32_t most) const;

  const Room& room_;
  bool cubic_;
  std::vector<OffsetExtent> extents_;
  // Of the left and of the right pixels: offsets between which nothing has to be asked for.
  std::array<OffsetRange, 2> known_{};
};

}  // namespace raywalk
