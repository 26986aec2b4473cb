// Writes the rays of a compressed line, as tiled_rays.h describes them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/room/hdf5_file.h"
#include "core/room/ray_form.h"
#include "core/room/tile_chunk.h"
#include "core/room/tile_layout.h"

namespace raywalk {

class TiledRaysWriter {
 public:
  // Creates the datasets in `hdf5`, which must outlive this. `form` must be compressed.
  TiledRaysWriter(Hdf5File* hdf5, const RayForm& form, int stations, PanoramaSize panorama,
                  int tile_columns);

  // Encodes a station's columns and replaces them by what they decode to, so that checksums are of
  // that. From any thread.
  TileChunk encode(std::span<std::uint8_t> rays) const;
  // Not thread-safe, as HDF5 is not. Throws Error where the file cannot be written.
  void write(int station, const TileChunk& chunk);

 private:
  Hdf5File* hdf5_;
  RayForm form_;
  TileLayout layout_;
  std::vector<TileSize> tiles_;
  std::vector<std::size_t> table_shape_;
  Hdf5Handle rays_;
  Hdf5Handle table_;
};

}  // namespace raywalk
