#include "core/room/tile_cache.h"

#include <algorithm>
#include <stdexcept>

#include "core/base/usable_memory.h"

namespace raywalk {
namespace {

// What a thread reads.
struct ThreadReading {
  int depth = 0;
  std::uint64_t epoch = 0;  // 0: no tile has been asked for yet
  std::int64_t hits = 0;
};
thread_local ThreadReading this_thread;

}  // namespace

TileCache::TileCache() : limit_bytes_(default_limit_bytes()) {}

TileCache& TileCache::of_process() {
  static TileCache cache;
  return cache;
}

std::uint64_t TileCache::default_limit_bytes() { return usable_memory_bytes() / 4; }

void TileCache::set_limit_bytes(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  limit_bytes_ = bytes;
  evict();
}

std::uint64_t TileCache::limit_bytes() const {
  const std::lock_guard lock(mutex_);
  return limit_bytes_;
}

TileCounts TileCache::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void TileCache::add(TileStore* store, std::int64_t tile, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  tiles_.push_back({store, tile, bytes, epoch()});
  ++counts_.decoded;
  counts_.bytes += bytes;
  counts_.most_bytes = std::max(counts_.most_bytes, counts_.bytes);
  evict();
}

void TileCache::forget(const TileStore* store) {
  const std::lock_guard lock(mutex_);
  std::erase_if(tiles_, [&](const Tile& tile) {
    if (tile.store != store) return false;
    counts_.bytes -= tile.bytes;
    return true;
  });
}

std::uint64_t TileCache::begin_reading() {
  const std::lock_guard lock(mutex_);
  readings_.push_back(epoch());
  return readings_.back();
}

void TileCache::end_reading(std::uint64_t epoch, std::int64_t hits) {
  const std::lock_guard lock(mutex_);
  counts_.hits += hits;
  *std::ranges::find(readings_, epoch) = readings_.back();
  readings_.pop_back();
  evict();
}

void TileCache::evict() {
  if (counts_.bytes <= limit_bytes_) return;
  // A little more than needed, so that not every tile decoded takes a round.
  const std::uint64_t goal = limit_bytes_ - limit_bytes_ / 16;
  // Readings that begin from now on do so after this round.
  const std::uint64_t now = epoch_.fetch_add(1, std::memory_order_acq_rel) + 1;
  const std::uint64_t oldest = readings_.empty() ? now : *std::ranges::min_element(readings_);
  // Twice, as a tile that was used since it was last looked at stays the first time.
  for (auto left = 2 * tiles_.size(); left > 0 && counts_.bytes > goal; --left) {
    Tile tile = tiles_.front();
    tiles_.pop_front();
    const std::uint64_t word = tile.store->word_of(tile.tile);
    if (word == tile.seen && word < oldest && tile.store->evict(tile.tile, word)) {
      counts_.bytes -= tile.bytes;
      ++counts_.evicted;
      continue;
    }
    tile.seen = word;
    tiles_.push_back(tile);
  }
}

TileReading::TileReading() { ++this_thread.depth; }

TileReading::~TileReading() {
  if (--this_thread.depth > 0 || this_thread.epoch == 0) return;
  TileCache::of_process().end_reading(this_thread.epoch, this_thread.hits);
  this_thread = {};
}

std::uint64_t TileReading::epoch_of_thread() {
  if (this_thread.epoch == 0) {
    if (this_thread.depth == 0) {
      throw std::logic_error("rays of a compressed line are read without a TileReading");
    }
    this_thread.epoch = TileCache::of_process().begin_reading();
  }
  return this_thread.epoch;
}

void TileReading::count_hits(std::int64_t hits) { this_thread.hits += hits; }

}  // namespace raywalk
