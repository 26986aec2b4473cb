// The rays of a compressed line: where they would be if they were mapped, each tile (tile_layout.h)
// decoded there when it is first asked for.
//
// Dataset `rays` of lines/<id>.h5: uint8 [station][theta][phi][rgb] in chunks of one station, with
// the filter of hdf5_filter.h. A chunk holds the filter's header and then the tiles, one after the
// other. Dataset `tiles`: uint64 [station][tiles + 1], stored contiguously: where in the file each
// tile begins, and where the last one ends. So a tile is read without HDF5, by any thread. Dataset
// `tile_columns`: int32 [1]. Root attribute `compression`: the form by its name (ray_form.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "core/geometry/sphere.h"
#include "core/room/hdf5_file.h"
#include "core/room/mapped_dataset.h"
#include "core/room/ray_form.h"
#include "core/room/tile_cache.h"
#include "core/room/tile_layout.h"

namespace raywalk {

inline constexpr const char* kCompressionAttribute = "compression";

class TiledRays : private TileStore {
 public:
  // Reads nothing but the header. Throws Error naming the file where datasets are missing or not of
  // the shapes that `stations` and `panorama` give, or the compression is unknown.
  static std::shared_ptr<TiledRays> open(const Hdf5File& hdf5, int stations, PanoramaSize panorama);
  ~TiledRays() override;
  TiledRays(const TiledRays&) = delete;
  TiledRays& operator=(const TiledRays&) = delete;

  int stations() const { return stations_; }
  const RayForm& form() const { return form_; }
  const TileLayout& layout() const { return layout_; }

  // A station's first ray. Only bytes that this thread's TileReading has asked for may be read, and
  // 16 bytes before and after them.
  const std::uint8_t* rays(int station) const {
    return first_ray_ + static_cast<std::size_t>(station) * stride_;
  }
  // Decodes the tiles that hold bytes [begin, end) of a station and those kSlack bytes around,
  // unless they are. From any thread, within a TileReading; std::logic_error without. Throws Error
  // naming the file where a tile is damaged.
  void require(int station, std::size_t begin, std::size_t end);

  // Whether the tile of a byte is decoded or was fetched.
  bool is_fetched(int station, std::size_t byte) const;
  // Starts reading from disk what tiles of bytes [begin, end) need that are not decoded and were
  // not fetched before.
  void fetch(int station, std::size_t begin, std::size_t end) const;

 private:
  TiledRays() = default;
  void reserve_memory();

  std::uint64_t word_of(std::int64_t tile) const override;
  bool evict(std::int64_t tile, std::uint64_t word) override;

  std::int64_t index_of(int station, int tile) const {
    return static_cast<std::int64_t>(station) * layout_.tiles() + tile;
  }
  // Waits for or decodes a tile that was not found decoded since `word` was read.
  void bring(int station, int tile);
  // Throws Error.
  void decode(int station, int tile);
  std::span<const std::uint8_t> read(int station, int tile) const;
  // Bytes [begin, end) of the file.
  struct FileBytes {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
  };
  FileBytes place_of(int station, int first_tile, int last_tile) const;
  [[noreturn]] void throw_damaged(int station, int tile, const std::string& what) const;

  std::filesystem::path path_;
  int stations_ = 0;
  RayForm form_;
  TileLayout layout_;
  MappedDataset table_;
  int file_ = -1;  // descriptor
  std::uint64_t file_bytes_ = 0;
  // Address space for the rays of all stations, of which only decoded tiles take memory.
  std::byte* space_ = nullptr;
  std::size_t space_bytes_ = 0;
  const std::uint8_t* first_ray_ = nullptr;
  std::size_t stride_ = 0;  // from one station to the next
  // A word for each tile (TileCache), in memory that the system zeroes when it is first used.
  std::uint64_t* words_ = nullptr;
  std::size_t words_bytes_ = 0;
};

}  // namespace raywalk
