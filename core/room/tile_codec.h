// Encodes and decodes tiles: pictures of a few columns of a station, [column][row][rgb].
//
// Lossless: green, red - green and blue - green, one plane after the other, each pixel as its
// difference from the pixel of the column before (in the first column, of the row before), modulo
// 256; then Zstandard (RFC 8878) with its checksum. Neighbouring columns are so alike that better
// predictions, such as the median of JPEG-LS, save under one per cent and cost several times as
// much to undo.
//
// JPEG: the CRC-32 (zlib's, little-endian) of a JPEG file without subsampled colours, and the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/room/ray_form.h"

namespace raywalk {

// A tile's size in pixels; both at least 1, at most 65500.
struct TileSize {
  int columns = 0;
  int rows = 0;
  std::size_t bytes() const {
    return 3 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  friend bool operator==(const TileSize&, const TileSize&) = default;
};

// The filter of encoded tiles for HDF5: one of the numbers that HDF5 leaves for use outside its
// registry, and what it is told of them: the form (1: lossless, 2: JPEG), their columns and rows.
inline constexpr int kTileFilter = 456;
inline std::vector<unsigned> filter_values(RayForm::Kind kind, TileSize size) {
  return {kind == RayForm::Kind::kJpeg ? 2U : 1U, static_cast<unsigned>(size.columns),
          static_cast<unsigned>(size.rows)};
}

// `form` must be compressed; `rgb` holds size.bytes() bytes. Throws std::bad_alloc only.
std::vector<std::uint8_t> encode_tile(const RayForm& form, TileSize size, const std::uint8_t* rgb);

// Writes size.bytes() bytes. False where `encoded` is damaged or a tile of another size: what was
// written is then of no use. From any thread.
bool decode_tile(RayForm::Kind kind, TileSize size, std::span<const std::uint8_t> encoded,
                 std::uint8_t* rgb);

}  // namespace raywalk
