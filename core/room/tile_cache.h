// The decoded tiles of all open rooms: bounded, shared by all threads, counted.
//
// A thread that reads rays of a compressed line does so while a TileReading is alive in it. What it
// asks for meanwhile stays decoded until its end. Tiles that no thread reads go, roughly those
// longest unused first, as soon as all of them take more than the limit. So memory exceeds the
// limit only by what threads read at this moment.
//
// How: time is an epoch that each round of evictions advances. A tile's word holds the epoch of
// its last use; a TileReading holds the epoch at which it first asked. Tiles used since the oldest
// of these stay. So while all tiles fit, a reader only compares a word with its epoch.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

namespace raywalk {

struct TileCounts {
  std::int64_t hits = 0;     // tiles asked for and found decoded
  std::int64_t decoded = 0;  // tiles decoded
  std::int64_t evicted = 0;
  std::uint64_t bytes = 0;       // of the tiles that are decoded now
  std::uint64_t most_bytes = 0;  // of those decoded at any time
};

// Where decoded tiles are; implemented by TiledRays.
class TileStore {
 public:
  virtual ~TileStore() = default;
  // The tile's word: see TileCache.
  virtual std::uint64_t word_of(std::int64_t tile) const = 0;
  // Frees the tile's memory if its word is still `word`.
  virtual bool evict(std::int64_t tile, std::uint64_t word) = 0;
};

class TileCache {
 public:
  // Values of a tile's word; from kFirstEpoch on it is decoded.
  static constexpr std::uint64_t kAbsent = 0;
  static constexpr std::uint64_t kFetched =
      1;                                     // absent, but its bytes were asked for from the disk
  static constexpr std::uint64_t kBusy = 2;  // a thread decodes it or frees its memory
  static constexpr std::uint64_t kFirstEpoch = 3;

  TileCache();

  // The cache of all rooms.
  static TileCache& of_process();

  // A quarter of the memory that the process may use (usable_memory.h).
  static std::uint64_t default_limit_bytes();
  void set_limit_bytes(std::uint64_t bytes);
  std::uint64_t limit_bytes() const;
  TileCounts counts() const;

  // The current epoch.
  std::uint64_t epoch() const { return epoch_.load(std::memory_order_acquire); }

  // A tile of `bytes` has been decoded; may evict others.
  void add(TileStore* store, std::int64_t tile, std::uint64_t bytes);
  // A store is about to go, and its tiles with it.
  void forget(const TileStore* store);

 private:
  friend class TileReading;
  struct Tile {
    TileStore* store = nullptr;
    std::int64_t tile = 0;
    std::uint64_t bytes = 0;
    std::uint64_t seen = 0;  // its word when it was last looked at
  };

  // The epoch that a thread's reading begins at.
  std::uint64_t begin_reading();
  void end_reading(std::uint64_t epoch, std::int64_t hits);
  void evict();

  mutable std::mutex mutex_;
  std::atomic<std::uint64_t> epoch_{kFirstEpoch};
  std::vector<std::uint64_t> readings_;  // epochs of the readings under way
  std::deque<Tile> tiles_;               // in about the order of their use
  std::uint64_t limit_bytes_;
  TileCounts counts_;
};

// While it is alive in a thread, the rays that the thread asks a compressed line for stay. They may
// be nested, as where a thread that waits takes up other work; then the outermost one counts. Costs
// nothing until a compressed line is read.
class TileReading {
 public:
  TileReading();
  ~TileReading();
  TileReading(const TileReading&) = delete;
  TileReading& operator=(const TileReading&) = delete;

  // The epoch of this thread's reading. Throws std::logic_error without one: rays read then could
  // vanish.
  static std::uint64_t epoch_of_thread();
  // Counts tiles that this thread found decoded.
  static void count_hits(std::int64_t hits);
};

}  // namespace raywalk
