// The filter of the rays of compressed lines, as HDF5 loads filters into programs that read files:
// a library of its own, found in a folder that raywalk.hdf5 names. It needs no library of HDF5.
// https://docs.hdfgroup.org/archive/support/HDF5/doc/Advanced/DynamicallyLoadedFilters
#include <H5PLextern.h>

#include <cstdint>
#include <cstdlib>
#include <exception>
#include <span>

#include "core/room/tile_chunk.h"

namespace raywalk {
namespace {

// Decodes a chunk into memory of its own; 0 where it cannot. `values` hold the chunk's decoded
// size.
std::size_t filter(unsigned flags, std::size_t value_count, const unsigned values[],
                   std::size_t bytes, std::size_t* buffer_bytes, void** buffer) {
  if ((flags & H5Z_FLAG_REVERSE) == 0 || value_count < 2) return 0;  // Raywalk encodes by itself
  const std::size_t decoded_bytes = values[0] | std::uint64_t{values[1]} << 32U;
  auto* const decoded = static_cast<std::uint8_t*>(std::malloc(decoded_bytes));
  if (decoded == nullptr) return 0;
  bool intact = false;
  try {
    intact =
        decode_chunk({static_cast<const std::uint8_t*>(*buffer), bytes}, {decoded, decoded_bytes});
  } catch (const std::exception&) {  // no memory; must not reach HDF5
  }
  if (!intact) {
    std::free(decoded);
    return 0;
  }
  std::free(*buffer);
  *buffer = decoded;
  *buffer_bytes = decoded_bytes;
  return decoded_bytes;
}

constexpr H5Z_class2_t kFilter = {H5Z_CLASS_T_VERS, kHdf5FilterId, 0,       1,
                                  "raywalk tiles",  nullptr,       nullptr, filter};

}  // namespace
}  // namespace raywalk

extern "C" {
H5PL_type_t H5PLget_plugin_type() { return H5PL_TYPE_FILTER; }
const void* H5PLget_plugin_info() { return &raywalk::kFilter; }
}
