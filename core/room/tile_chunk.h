// A chunk of dataset `rays` of a compressed line: all tiles of one station, as HDF5's filter
// decodes them (hdf5_filter.cc). Little-endian uint32 numbers: kChunkMagic, the form (1: lossless,
// 2: JPEG), the number of tiles, then for each its columns, rows and encoded bytes; then the
// encoded tiles. Decoded, they follow each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/room/tile_codec.h"

namespace raywalk {

// Of the filter: one of those that HDF5 leaves for use outside its registry.
inline constexpr int kHdf5FilterId = 456;
inline constexpr std::uint32_t kChunkMagic = 0x31545752;  // "RWT1"

struct TileChunk {
  std::vector<std::uint8_t> bytes;
  // Where in it each tile begins, and where the last one ends.
  std::vector<std::uint64_t> places;
};

// Of tiles that follow each other in `rgb`. `form` must be compressed.
TileChunk encode_chunk(const RayForm& form, std::span<const TileSize> tiles,
                       std::span<const std::uint8_t> rgb);

// Writes what the chunk holds to `rgb`. False where the chunk is damaged or holds less or more.
bool decode_chunk(std::span<const std::uint8_t> chunk, std::span<std::uint8_t> rgb);

}  // namespace raywalk
