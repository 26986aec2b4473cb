#include "core/room/tiled_rays_writer.h"

#include <array>
#include <stdexcept>

#include "core/room/tiled_rays.h"

namespace raywalk {

TiledRaysWriter::TiledRaysWriter(Hdf5File* hdf5, const RayForm& form, int stations,
                                 PanoramaSize panorama, int tile_columns)
    : hdf5_(hdf5), form_(form), layout_(panorama, tile_columns) {
  for (int tile = 0; tile < layout_.tiles(); ++tile) tiles_.push_back(layout_.size_of(tile));
  const auto count = static_cast<std::size_t>(stations);
  const std::array<std::size_t, 4> shape{count, static_cast<std::size_t>(panorama.width),
                                         static_cast<std::size_t>(panorama.height), 3};
  rays_ = hdf5->create_filtered("rays", H5T_STD_U8LE, shape, kHdf5FilterId);
  table_shape_ = {count, tiles_.size() + 1};
  table_ = hdf5->create_contiguous("tiles", H5T_STD_U64LE, table_shape_);
  hdf5->write_attribute("/", kCompressionAttribute, name_of(form));
  hdf5->write_int32("tile_columns", std::array{static_cast<std::int32_t>(tile_columns)});
}

TileChunk TiledRaysWriter::encode(std::span<std::uint8_t> rays) const {
  TileChunk chunk = encode_chunk(form_, tiles_, rays);
  if (form_.kind == RayForm::Kind::kJpeg && !decode_chunk(chunk.bytes, rays)) {
    throw std::logic_error("tiles cannot be decoded that have just been encoded");
  }
  return chunk;
}

void TiledRaysWriter::write(int station, const TileChunk& chunk) {
  const auto index = static_cast<std::size_t>(station);
  const std::uint64_t begin = hdf5_->write_chunk(rays_, index, chunk.bytes);
  std::vector<std::uint64_t> places;
  for (const std::uint64_t place : chunk.places) places.push_back(begin + place);
  hdf5_->write_slab(table_, index, H5T_NATIVE_UINT64, table_shape_, places.data());
}

}  // namespace raywalk
