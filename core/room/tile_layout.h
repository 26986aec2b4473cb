// How a station's rays, as line_volume.h has them, are cut into tiles: the columns, so many to a
// tile, then each level of the polar part in pieces of about as many bytes. Tiles follow each other
// as their bytes do, so that each is decoded to one run of bytes.
#pragma once

#include <cstddef>
#include <vector>

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
  // `tile_columns` in [1, width]. With the polar part of the panoramas if they have one.
  TileLayout(PanoramaSize size, int tile_columns);

  int tiles() const { return tiles_; }
  TileSize size_of(int tile) const;
  // The tile's first byte, counted from the station's first ray.
  std::size_t begin_of(int tile) const;
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
    if (byte >= end_of_columns_) return tile_of_polar_byte(byte);
    // Exact: half a byte is far more than what rounding is off by.
    return static_cast<int>((static_cast<double>(byte) + 0.5) * tiles_per_byte_);
  }
  // Bytes of all columns and of the columns that hold the polar part; those behind the last tile
  // are 0.
  std::size_t station_bytes() const { return station_bytes_; }

 private:
  // Tiles of one size, but for the last, which may have fewer columns.
  struct Part {
    int first_tile = 0;
    int end_tile = 0;
    std::size_t begin = 0;
    int columns = 0;
    TileSize tile{};
  };
  void append(int columns, TileSize tile);
  const Part& part_of(int tile) const;
  int tile_of_polar_byte(std::size_t byte) const;

  std::vector<Part> parts_;
  int tiles_ = 0;
  std::size_t end_ = 0;  // of the last tile
  std::size_t end_of_columns_ = 0;
  double tiles_per_byte_ = 0.0;  // of the columns
  std::size_t station_bytes_ = 0;
};

}  // namespace raywalk
