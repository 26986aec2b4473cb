// How a station's rays, as line_volume.h has them, are cut into tiles of so many columns; the last
// one may have fewer. Tiles follow each other as their bytes do, so that each is decoded to one run
// of bytes.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/geometry/sphere.h"
#include "core/room/tile_codec.h"

namespace raywalk {

// Columns to a tile for panoramas of this size unless a file says otherwise: enough that a tile
// compresses well, few enough that a view, which reads some neighbouring columns of each station,
// decodes little more than it reads.
int usual_tile_columns(PanoramaSize size);

class TileLayout {
 public:
  TileLayout() = default;
  // `tile_columns` in [1, width].
  TileLayout(PanoramaSize size, int tile_columns)
      : columns_(size.width),
        tile_{tile_columns, size.height},
        tiles_((size.width + tile_columns - 1) / tile_columns),
        tiles_per_byte_(1.0 / static_cast<double>(tile_.bytes())) {}

  int tiles() const { return tiles_; }
  TileSize size_of(int tile) const {
    return {std::min(tile_.columns, columns_ - tile * tile_.columns), tile_.rows};
  }
  // The tile's first byte, counted from the station's first ray.
  std::size_t begin_of(int tile) const { return static_cast<std::size_t>(tile) * tile_.bytes(); }
  std::size_t end_of(int tile) const { return begin_of(tile) + size_of(tile).bytes(); }
  struct Bytes {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  // Of the tile that a byte lies in.
  Bytes bytes_around(std::size_t byte) const {
    const int tile = tile_of(byte);
    return {begin_of(tile), end_of(tile)};
  }
  // The tile that a byte lies in; the last one for bytes behind all tiles.
  int tile_of(std::size_t byte) const {
    // Exact: half a byte is far more than what rounding is off by.
    return std::min(static_cast<int>((static_cast<double>(byte) + 0.5) * tiles_per_byte_),
                    tiles_ - 1);
  }
  // Bytes of all columns.
  std::size_t station_bytes() const { return TileSize{columns_, tile_.rows}.bytes(); }

 private:
  int columns_ = 0;
  TileSize tile_{};  // of all but the last
  int tiles_ = 0;
  double tiles_per_byte_ = 0.0;
};

}  // namespace raywalk
