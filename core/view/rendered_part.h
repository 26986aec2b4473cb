// A part of a panorama that is rendered, and what could not be read of it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/room/line_volume.h"

namespace raywalk {

// Output rows of a column that nothing could be read for.
struct UnreadRows {
  int column = 0;  // of the panorama
  RowRun rows{};
};

// How pixels were read.
struct PixelCounts {
  std::int64_t all = 0;
  std::int64_t filled = 0;  // occluded from the lines in use, read from another station
  std::int64_t unseen = 0;  // could not be read
  std::int64_t empty = 0;   // of columns that no line serves

  PixelCounts& operator+=(const PixelCounts& other) {
    all += other.all;
    filled += other.filled;
    unseen += other.unseen;
    empty += other.empty;
    return *this;
  }
};

}  // namespace raywalk
