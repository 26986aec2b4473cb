// The polar part of a station's rays: the rows near the poles a second time, for each level of
// PolarColumns of just the columns that views read at it.
//
// In a volume it follows the station's columns, as further columns that it fills from the first on.
// Level d = 1..4 has columns 0, 2^d, 2 * 2^d, ...; of each the rows around samples of this level at
// the north pole, then those at the south pole, rgb. Levels follow each other.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/room/polar_columns.h"

namespace raywalk {

// Columns up to 2^k apart are interpolated between where they still lie within half a row's height
// of each other: as exact as the interpolation between rows, from fewer columns. A level 2^k that
// does not divide the panorama's width is not used.
PolarColumns polar_columns(PanoramaSize size);

struct RayPlace {
  int column = 0;
  int row = 0;
  friend bool operator==(const RayPlace&, const RayPlace&) = default;
};

class PolarPart {
 public:
  PolarPart() = default;  // of an empty panorama
  explicit PolarPart(PanoramaSize size);

  // Columns of the volume that it takes, the last one partly; 0 for panoramas too small to have
  // one.
  int columns() const { return columns_; }
  // Of rays that the part follows, and of rays without one.
  const RayLayout& layout() const { return layout_; }
  RayLayout layout_without() const;

  // `rays`: [theta][phi][rgb] of a station. `part`: columns() columns; bytes that are not used are
  // set to 0.
  void fill(std::span<const std::uint8_t> rays, std::span<std::uint8_t> part) const;

  // The levels that have rows, in order: each is a picture [column][row][rgb] of the rows at the
  // north pole above those at the south pole.
  struct Picture {
    int columns = 0;
    int rows = 0;
  };
  std::vector<Picture> pictures() const;

  // The pixel at a byte offset from the first ray, in the columns or in the part.
  RayPlace place_of(std::int32_t offset) const;

 private:
  struct Level {
    std::int32_t begin = 0;  // byte offset from the first ray
    std::int32_t end = 0;
    int first_row = 0;  // at the north pole; none: rows == 0
    int rows = 0;       // at each pole
  };

  int first_southern_row(const Level& level) const {
    return size_.height - level.first_row - level.rows;
  }
  std::int32_t column_bytes() const { return 3 * size_.height; }

  PanoramaSize size_;
  std::array<Level, PolarColumns::kMaxDoublings + 1> levels_{};  // by doublings; 0 is not used
  RayLayout layout_;
  int columns_ = 0;
};

}  // namespace raywalk
