#include "core/room/tile_layout.h"

#include <algorithm>

#include "core/room/polar_part.h"

namespace raywalk {
namespace {

// JPEG codes blocks of 8 x 8 pixels.
constexpr int kBlock = 8;

int whole_blocks(int pixels) { return (pixels + kBlock - 1) / kBlock * kBlock; }

}  // namespace

int usual_tile_columns(PanoramaSize size) {
  constexpr int kPixels = 16384;
  constexpr int kLeast = 16;
  return std::min(std::max(whole_blocks(kPixels / size.height), kLeast), size.width);
}

TileLayout::TileLayout(PanoramaSize size, int tile_columns) {
  append(size.width, {tile_columns, size.height});
  end_of_columns_ = end_;
  tiles_per_byte_ = 1.0 / static_cast<double>(parts_.front().tile.bytes());
  const PolarPart polar_part(size);
  for (const PolarPart::Picture& level : polar_part.pictures()) {
    const int columns = whole_blocks(tile_columns * size.height / level.rows);
    append(level.columns, {std::min(columns, level.columns), level.rows});
  }
  station_bytes_ = 3 * static_cast<std::size_t>(size.width + polar_part.columns()) *
                   static_cast<std::size_t>(size.height);
}

void TileLayout::append(int columns, TileSize tile) {
  const int count = (columns + tile.columns - 1) / tile.columns;
  parts_.push_back({tiles_, tiles_ + count, end_, columns, tile});
  tiles_ += count;
  end_ += TileSize{columns, tile.rows}.bytes();
}

const TileLayout::Part& TileLayout::part_of(int tile) const {
  return *std::ranges::find_if(parts_, [&](const Part& part) { return tile < part.end_tile; });
}

TileSize TileLayout::size_of(int tile) const {
  const Part& part = part_of(tile);
  const int before = (tile - part.first_tile) * part.tile.columns;
  return {std::min(part.tile.columns, part.columns - before), part.tile.rows};
}

std::size_t TileLayout::begin_of(int tile) const {
  const Part& part = part_of(tile);
  return part.begin + static_cast<std::size_t>(tile - part.first_tile) * part.tile.bytes();
}

int TileLayout::tile_of_polar_byte(std::size_t byte) const {
  if (byte >= end_) return tiles_ - 1;
  const auto part =
      std::ranges::find_if(parts_.rbegin(), parts_.rend(),
                           [&](const Part& candidate) { return byte >= candidate.begin; });
  return part->first_tile + static_cast<int>((byte - part->begin) / part->tile.bytes());
}

}  // namespace raywalk
