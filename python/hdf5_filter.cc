// The filter of the rays of compressed lines, as HDF5 loads filters into programs that read files:
// a library of its own, found in a folder that raywalk.hdf5 names. It needs no library of HDF5.
// https://docs.hdfgroup.org/archive/support/HDF5/doc/Advanced/DynamicallyLoadedFilters
#include <H5PLextern.h>

#include <cstdint>
#include <cstdlib>
#include <exception>

#include "core/room/tile_codec.h"

namespace raywalk {
namespace {

// Decodes a tile into memory of its own; 0 where it cannot. `values` are filter_values() of tiles.
std::size_t filter(unsigned flags, std::size_t value_count, const unsigned values[],
                   std::size_t bytes, std::size_t* buffer_bytes, void** buffer) {
  constexpr unsigned kMostSide = 65500;
  if ((flags & H5Z_FLAG_REVERSE) == 0 || value_count < 3 || values[0] < 1 || values[0] > 2 ||
      values[1] - 1 >= kMostSide || values[2] - 1 >= kMostSide) {
    return 0;  // Raywalk encodes by itself
  }
  const RayForm::Kind kind = values[0] == 2 ? RayForm::Kind::kJpeg : RayForm::Kind::kLossless;
  const TileSize size{static_cast<int>(values[1]), static_cast<int>(values[2])};
  auto* const decoded = static_cast<std::uint8_t*>(std::malloc(size.bytes()));
  if (decoded == nullptr) return 0;
  bool intact = false;
  try {
    intact = decode_tile(kind, size, {static_cast<const std::uint8_t*>(*buffer), bytes}, decoded);
  } catch (const std::exception&) {  // no memory; must not reach HDF5
  }
  if (!intact) {
    std::free(decoded);
    return 0;
  }
  std::free(*buffer);
  *buffer = decoded;
  *buffer_bytes = size.bytes();
  return size.bytes();
}

constexpr H5Z_class2_t kFilter = {H5Z_CLASS_T_VERS, kTileFilter, 0,       1,
                                  "raywalk tiles",  nullptr,     nullptr, filter};

}  // namespace
}  // namespace raywalk

extern "C" {
H5PL_type_t H5PLget_plugin_type() { return H5PL_TYPE_FILTER; }
const void* H5PLget_plugin_info() { return &raywalk::kFilter; }
}
