// The rays of a compressed line: where they would be if they were mapped, each tile decoded there
// when it is first asked for. A tile is a picture of some columns of a station.
//
// Dataset `rays` of lines/<id>.h5: uint8 [station][theta][phi][rgb] in chunks of one tile, encoded
// (tile_codec.h). Dataset `tiles`: uint64 [station][tile][2], where in the file each tile begins,
// and its bytes. So a tile is read without HDF5, by any thread. Root attribute `compression`: the
// form by its name (ray_form.h).
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <shared_mutex>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/room/hdf5_file.h"
#include "core/room/ray_form.h"
#include "core/room/tile_codec.h"

namespace raywalk {

// How a station's rays, as line_volume.h has them, are cut into tiles of as many columns each,
// which follow each other as their bytes do.
class TileLayout {
 public:
  // `tile_columns` must divide the width.
  TileLayout(PanoramaSize size, int tile_columns)
      : tile_{tile_columns, size.height}, tiles_(size.width / tile_columns) {}

  // A tile has enough columns that it compresses well, and few enough that a view, which reads some
  // neighbouring columns of each station, decodes little more than it reads.
  static TileLayout usual(PanoramaSize size);

  int tiles() const { return tiles_; }
  TileSize tile() const { return tile_; }
  std::size_t tile_bytes() const { return tile_.bytes(); }
  std::size_t station_bytes() const { return static_cast<std::size_t>(tiles_) * tile_bytes(); }
  // The tile that a byte lies in, counted from the station's first ray; the last one for bytes
  // behind all tiles.
  int tile_of(std::size_t byte) const {
    return static_cast<int>(std::min(byte / tile_bytes(), static_cast<std::size_t>(tiles_) - 1));
  }
  struct Bytes {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  Bytes bytes_of(int tile) const {
    const std::size_t begin = static_cast<std::size_t>(tile) * tile_bytes();
    return {begin, begin + tile_bytes()};
  }

 private:
  TileSize tile_;
  int tiles_;
};

class TiledRays {
 public:
  // Reads nothing but the header of a file whose dataset `rays` has the shape that `stations` and
  // `panorama` give. Throws Error naming the file where `tiles` is missing or of another shape, or
  // the compression is unknown.
  TiledRays(const Hdf5File& hdf5, int stations, PanoramaSize panorama);
  ~TiledRays();
  TiledRays(const TiledRays&) = delete;
  TiledRays& operator=(const TiledRays&) = delete;

  const RayForm& form() const { return form_; }
  const TileLayout& layout() const { return layout_; }

  // A station's first ray. Only bytes that this thread's TileReading has asked for may be read, and
  // 16 bytes before and after them.
  const std::uint8_t* rays(int station) const {
    return first_ray_ + static_cast<std::size_t>(station) * stride_;
  }
  // Decodes the tiles that hold bytes [begin, end) of a station and the few around, unless they
  // are. From any thread, within a TileReading; std::logic_error without. Throws Error naming the
  // file where a tile is damaged.
  void require(int station, std::size_t begin, std::size_t end);

  // Whether the tile of a byte is decoded.
  bool is_decoded(int station, std::size_t byte) const;
  // Starts reading from disk what tiles of bytes [begin, end) need that are not decoded.
  void fetch(int station, std::size_t begin, std::size_t end) const;

  // Frees the memory of a tile unless it was used since it was last asked to. While nobody reads.
  bool evict_unless_used(std::int64_t tile);

 private:
  enum class State : std::uint8_t { kAbsent, kDecoded, kUsed };

  std::int64_t index_of(int station, int tile) const {
    return static_cast<std::int64_t>(station) * layout_.tiles() + tile;
  }
  State state_of(std::int64_t tile) const {
    return states_[static_cast<std::size_t>(tile)].load(std::memory_order_acquire);
  }
  FilePlace place_of(std::int64_t tile) const;
  // Decodes a tile, unless another thread has.
  void bring(int station, int tile);
  // Its encoded bytes.
  std::vector<std::uint8_t> read(int station, int tile) const;
  [[noreturn]] void throw_damaged(int station, int tile, const std::string& what) const;

  std::filesystem::path path_;
  RayForm form_;
  TileLayout layout_;
  std::vector<std::uint64_t> places_;
  int file_ = -1;  // descriptor
  // Address space for the rays of all stations, of which only decoded tiles take memory.
  std::byte* space_ = nullptr;
  std::size_t space_bytes_ = 0;
  const std::uint8_t* first_ray_ = nullptr;
  std::size_t stride_ = 0;  // from one station to the next
  std::vector<std::atomic<State>> states_;
  std::array<std::mutex, 64> decoding_;  // of the tiles of a remainder modulo 64
};

struct TileCounts {
  std::int64_t decoded = 0;  // tiles decoded
  std::int64_t evicted = 0;
  std::uint64_t bytes = 0;  // of the tiles that are decoded now
};

// The decoded tiles of all open rooms: bounded, shared by all threads, counted.
//
// A thread that reads rays of a compressed line does so while a TileReading is alive in it. What it
// asks for meanwhile stays decoded until its end. As soon as all tiles together take more than the
// limit, a thread whose reading ends waits for those of the others to end, and evicts tiles,
// roughly those longest unused first. So memory exceeds the limit only by what threads read at that
// moment.
class TileCache {
 public:
  // The cache of all rooms.
  static TileCache& of_process();

  // A quarter of the memory that the process may use (usable_memory.h).
  static std::uint64_t default_limit_bytes();
  // Not while this thread reads.
  void set_limit_bytes(std::uint64_t bytes);
  TileCounts counts() const;

  // A tile has been decoded.
  void add(TiledRays* rays, std::int64_t tile);
  // Rays are about to go, and their tiles with them.
  void forget(const TiledRays* rays);

 private:
  friend class TileReading;
  struct Tile {
    TiledRays* rays = nullptr;
    std::int64_t tile = 0;
  };

  void evict_if_full();

  std::shared_mutex reading_;  // shared by the readings under way
  std::atomic<bool> full_ = false;
  mutable std::mutex mutex_;  // of what follows
  std::deque<Tile> tiles_;    // in about the order of their use
  std::uint64_t limit_bytes_ = default_limit_bytes();
  TileCounts counts_;
};

// While it is alive in a thread, the rays that the thread asks a compressed line for stay. Nested
// ones are of no effect. A thread that reads must not wait for others, as in a parallel loop or
// where OpenCV has one: these may wait for it to evict tiles.
class TileReading {
 public:
  TileReading();
  ~TileReading();
  TileReading(const TileReading&) = delete;
  TileReading& operator=(const TileReading&) = delete;

  // Throws std::logic_error unless this thread has one: rays read then could vanish.
  static void require_one();
};

// Writes the rays of a compressed line into `hdf5`, which must outlive this.
class TiledRaysWriter {
 public:
  // Creates the dataset. `form` must be compressed.
  TiledRaysWriter(Hdf5File* hdf5, const RayForm& form, int stations, PanoramaSize panorama,
                  const TileLayout& layout);

  using Encoded = std::vector<std::vector<std::uint8_t>>;  // of each tile
  // Encodes a station's columns and replaces them by what they decode to, so that checksums are of
  // that. From any thread.
  Encoded encode(std::span<std::uint8_t> rays) const;
  // Throws Error where the file cannot be written.
  void write(int station, const Encoded& tiles);
  // After all stations are written.
  void complete();

 private:
  Hdf5File* hdf5_;
  RayForm form_;
  TileLayout layout_;
  std::vector<std::uint64_t> places_;
};

}  // namespace raywalk
