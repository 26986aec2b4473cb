#include "core/room/tile_chunk.h"

namespace raywalk {
namespace {

constexpr std::size_t kNumbersBefore = 3;  // magic, form, tiles
constexpr std::size_t kNumbersPerTile = 3;
constexpr std::uint32_t kLargestSide = 65500;  // of a JPEG picture

void append(std::uint32_t number, std::vector<std::uint8_t>* bytes) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes->push_back(static_cast<std::uint8_t>(number >> shift));
  }
}

// The number at index i of those that a chunk begins with.
std::uint32_t number_at(std::span<const std::uint8_t> chunk, std::size_t i) {
  std::uint32_t number = 0;
  for (std::size_t byte = 0; byte < 4; ++byte) {
    number |= static_cast<std::uint32_t>(chunk[4 * i + byte]) << (8 * byte);
  }
  return number;
}

}  // namespace

TileChunk encode_chunk(const RayForm& form, std::span<const TileSize> tiles,
                       std::span<const std::uint8_t> rgb) {
  TileChunk chunk;
  append(kChunkMagic, &chunk.bytes);
  append(form.kind == RayForm::Kind::kJpeg ? 2 : 1, &chunk.bytes);
  append(static_cast<std::uint32_t>(tiles.size()), &chunk.bytes);
  std::vector<std::uint8_t> encoded;
  std::uint64_t place = 4 * (kNumbersBefore + kNumbersPerTile * tiles.size());
  for (const TileSize& tile : tiles) {
    const std::vector<std::uint8_t> bytes = encode_tile(form, tile, rgb.data());
    rgb = rgb.subspan(tile.bytes());
    append(static_cast<std::uint32_t>(tile.columns), &chunk.bytes);
    append(static_cast<std::uint32_t>(tile.rows), &chunk.bytes);
    append(static_cast<std::uint32_t>(bytes.size()), &chunk.bytes);
    encoded.insert(encoded.end(), bytes.begin(), bytes.end());
    chunk.places.push_back(place);
    place += bytes.size();
  }
  chunk.places.push_back(place);
  chunk.bytes.insert(chunk.bytes.end(), encoded.begin(), encoded.end());
  return chunk;
}

bool decode_chunk(std::span<const std::uint8_t> chunk, std::span<std::uint8_t> rgb) {
  if (chunk.size() < 4 * kNumbersBefore || number_at(chunk, 0) != kChunkMagic) return false;
  const std::uint32_t form = number_at(chunk, 1);
  const std::size_t tiles = number_at(chunk, 2);
  if ((form != 1 && form != 2) || tiles > chunk.size() / (4 * kNumbersPerTile)) return false;
  const RayForm::Kind kind = form == 2 ? RayForm::Kind::kJpeg : RayForm::Kind::kLossless;
  std::size_t place = 4 * (kNumbersBefore + kNumbersPerTile * tiles);
  if (place > chunk.size()) return false;
  for (std::size_t i = 0; i < tiles; ++i) {
    const auto number = [&](std::size_t j) {
      return number_at(chunk, kNumbersBefore + kNumbersPerTile * i + j);
    };
    if (number(0) - 1 >= kLargestSide || number(1) - 1 >= kLargestSide) return false;
    const TileSize tile{static_cast<int>(number(0)), static_cast<int>(number(1))};
    const std::size_t bytes = number(2);
    if (tile.bytes() > rgb.size() || bytes > chunk.size() - place) return false;
    if (!decode_tile(kind, tile, chunk.subspan(place, bytes), rgb.data())) return false;
    place += bytes;
    rgb = rgb.subspan(tile.bytes());
  }
  return rgb.empty();
}

}  // namespace raywalk
