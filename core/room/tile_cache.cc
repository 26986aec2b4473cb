#include "core/room/tile_cache.h"

#include <algorithm>
#include <stdexcept>

#include "core/base/usable_memory.h"
#include "core/room/tiled_rays.h"

namespace raywalk {
namespace {

thread_local int readings_of_thread = 0;

}  // namespace

TileCache& TileCache::of_process() {
  static TileCache cache;
  return cache;
}

std::uint64_t TileCache::default_limit_bytes() { return usable_memory_bytes() / 4; }

void TileCache::set_limit_bytes(std::uint64_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    limit_bytes_ = bytes;
    full_ = counts_.bytes > limit_bytes_;
  }
  evict_if_full();
}

TileCounts TileCache::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void TileCache::add(TiledRays* rays, std::int64_t tile) {
  const std::lock_guard lock(mutex_);
  tiles_.push_back({rays, tile});
  ++counts_.decoded;
  counts_.bytes += rays->layout().tile_bytes();
  counts_.most_bytes = std::max(counts_.most_bytes, counts_.bytes);
  full_ = counts_.bytes > limit_bytes_;
}

void TileCache::forget(const TiledRays* rays) {
  const std::lock_guard lock(mutex_);
  const auto gone = std::erase_if(tiles_, [&](const Tile& tile) { return tile.rays == rays; });
  counts_.bytes -= gone * rays->layout().tile_bytes();
}

void TileCache::evict_if_full() {
  if (!full_.load(std::memory_order_relaxed)) return;
  const std::unique_lock nobody_reads(reading_);
  const std::lock_guard lock(mutex_);
  if (counts_.bytes <= limit_bytes_) return;
  // A little more than needed, so that not every tile decoded takes a round.
  const std::uint64_t goal = limit_bytes_ - limit_bytes_ / 16;
  while (counts_.bytes > goal) {
    const Tile tile = tiles_.front();
    tiles_.pop_front();
    if (tile.rays->evict_unless_used(tile.tile)) {
      counts_.bytes -= tile.rays->layout().tile_bytes();
      ++counts_.evicted;
    } else {
      tiles_.push_back(tile);
    }
  }
  full_ = false;
}

TileReading::TileReading() {
  if (readings_of_thread++ == 0) TileCache::of_process().reading_.lock_shared();
}

TileReading::~TileReading() {
  if (--readings_of_thread > 0) return;
  TileCache::of_process().reading_.unlock_shared();
  TileCache::of_process().evict_if_full();
}

void TileReading::require_one() {
  if (readings_of_thread == 0) {
    throw std::logic_error("rays of a compressed line are read without a TileReading");
  }
}

}  // namespace raywalk
