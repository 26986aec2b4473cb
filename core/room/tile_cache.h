// The decoded tiles of all open rooms: bounded, shared by all threads, counted.
//
// A thread that reads rays of a compressed line does so while a TileReading is alive in it. What it
// asks for meanwhile stays decoded until its end. As soon as all tiles together take more than the
// limit, a thread whose reading ends waits for those of the others to end, and evicts tiles,
// roughly those longest unused first. So memory exceeds the limit only by what threads read at that
// moment.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <shared_mutex>

namespace raywalk {

class TiledRays;

struct TileCounts {
  std::int64_t decoded = 0;  // tiles decoded
  std::int64_t evicted = 0;
  std::uint64_t bytes = 0;       // of the tiles that are decoded now
  std::uint64_t most_bytes = 0;  // of those decoded at any time
};

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

}  // namespace raywalk
