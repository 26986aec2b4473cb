// Runs of a column's rows that are read in the same way.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "core/room/line_volume.h"
#include "core/view/view_plan.h"

namespace raywalk {

enum class Reading : std::uint8_t {
  kNothing,
  kStored,  // rows of the plain cut, uncorrected
  kFirst,   // samples of the station before the acquisition point, or of the one after it
  kSecond,
  kBoth
};

// Whether the station before (0) or after (1) the acquisition point is sampled.
inline bool reads(Reading reading, int next) {
  return reading == Reading::kBoth || reading == (next == 0 ? Reading::kFirst : Reading::kSecond);
}

// That of a source's two stations which is nearer to the acquisition point.
inline Reading nearer_station(const RaySource& source) {
  return source.fraction < 0.5 ? Reading::kFirst : Reading::kSecond;
}

// Flags of rows, 0 or 1.
inline bool any_is(std::span<const std::uint8_t> rows, std::uint8_t value) {
  return std::memchr(rows.data(), value, rows.size()) != nullptr;
}

// Erodes every run of 1s by a row on both sides, except at the poles.
inline void keep_with_neighbours(std::vector<std::uint8_t>* rows) {
  std::uint8_t before = 1;
  for (std::size_t row = 0; row < rows->size(); ++row) {
    const std::uint8_t here = (*rows)[row];
    const bool after = row + 1 == rows->size() || (*rows)[row + 1] != 0;
    (*rows)[row] = here && before && after;
    before = here;
  }
}

struct RowPiece {
  RowRun rows;  // of the output
  Reading reading = Reading::kBoth;
};

}  // namespace raywalk
