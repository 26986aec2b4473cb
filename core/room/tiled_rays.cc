#include "core/room/tiled_rays.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "core/base/error.h"
#include "core/base/usable_memory.h"
#include "core/room/mapped_dataset.h"

namespace raywalk {
namespace {

// Vector loads reach a few bytes over what is asked for.
constexpr std::size_t kSlack = 16;

std::size_t whole_pages(std::size_t bytes) {
  return (bytes + page_bytes() - 1) / page_bytes() * page_bytes();
}

thread_local int readings_of_thread = 0;

std::string reason_of(int number) { return std::generic_category().message(number); }

RayForm form_of(const Hdf5File& hdf5) {
  const std::string name = hdf5.text_attribute("compression").value_or("");
  try {
    const RayForm form = ray_form_from_name(name);
    if (form.compressed()) return form;
  } catch (const UsageError&) {  // said below, where the file is known
  }
  throw Error(fmt::format("{}: its compression '{}' is unknown; use a newer Raywalk",
                          hdf5.path().string(), excerpt(name)));
}

Shape shape_of_rays(int stations, PanoramaSize panorama) {
  return {static_cast<std::size_t>(stations), static_cast<std::size_t>(panorama.width),
          static_cast<std::size_t>(panorama.height), 3};
}

TileLayout layout_of(const Hdf5File& hdf5, PanoramaSize panorama) {
  const std::size_t columns = hdf5.chunk_of("rays").value_or(Shape{0, 0, 0, 0}).at(1);
  const auto width = static_cast<std::size_t>(panorama.width);
  if (columns == 0 || columns > width || width % columns != 0) {
    throw Error(hdf5.path().string() + ": dataset 'rays' is not in tiles of equal size");
  }
  return {panorama, static_cast<int>(columns)};
}

}  // namespace

TileLayout TileLayout::usual(PanoramaSize size) {
  constexpr int kPixels = 16384;
  constexpr int kLeast = 16;
  const int most = std::max(kPixels / size.height, kLeast);
  // JPEG codes blocks of 8 x 8 pixels.
  int best = 1;
  for (int columns = 1; columns <= std::min(most, size.width); ++columns) {
    if (size.width % columns == 0 && (columns % 8 == 0 || best % 8 != 0)) best = columns;
  }
  return {size, best};
}

TiledRays::TiledRays(const Hdf5File& hdf5, int stations, PanoramaSize panorama)
    : path_(hdf5.path()), form_(form_of(hdf5)), layout_(layout_of(hdf5, panorama)) {
  hdf5.require_shape(
      "tiles", {static_cast<std::size_t>(stations), static_cast<std::size_t>(layout_.tiles()), 2});
  places_ = hdf5.read<std::uint64_t>("tiles");
  states_ = std::vector<std::atomic<State>>(static_cast<std::size_t>(index_of(stations, 0)));
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw Error(fmt::format("{}: {}", path_.string(), reason_of(errno)));
  // Each station begins with a page and ends with kSlack bytes that no other station has.
  stride_ = whole_pages(layout_.station_bytes() + kSlack);
  space_bytes_ = page_bytes() + static_cast<std::size_t>(stations) * stride_;
  void* const space = ::mmap(nullptr, space_bytes_, PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (space == MAP_FAILED) {
    const std::string reason = reason_of(errno);
    ::close(file_);
    throw Error(fmt::format("{}: no address space for {} bytes of rays: {}", path_.string(),
                            space_bytes_, reason));
  }
  space_ = static_cast<std::byte*>(space);
  first_ray_ = reinterpret_cast<const std::uint8_t*>(space_ + page_bytes());
}

TiledRays::~TiledRays() {
  TileCache::of_process().forget(this);
  ::munmap(space_, space_bytes_);
  ::close(file_);
}

void TiledRays::require(int station, std::size_t begin, std::size_t end) {
  TileReading::require_one();
  const int last = layout_.tile_of(end - 1 + kSlack);
  for (int tile = layout_.tile_of(begin - std::min(begin, kSlack)); tile <= last; ++tile) {
    if (state_of(index_of(station, tile)) != State::kUsed) bring(station, tile);
  }
}

void TiledRays::bring(int station, int tile) {
  const std::int64_t index = index_of(station, tile);
  // Of the threads that want a tile at once, one decodes it and the others wait.
  const std::lock_guard lock(decoding_[static_cast<std::size_t>(index) % decoding_.size()]);
  if (state_of(index) == State::kAbsent) {
    auto* const out = const_cast<std::uint8_t*>(rays(station)) + layout_.bytes_of(tile).begin;
    if (!decode_tile(form_.kind, layout_.tile(), read(station, tile), out)) {
      throw_damaged(station, tile, "cannot be decoded");
    }
    TileCache::of_process().add(this, index);
  }
  states_[static_cast<std::size_t>(index)].store(State::kUsed, std::memory_order_release);
}

FilePlace TiledRays::place_of(std::int64_t tile) const {
  const auto i = 2 * static_cast<std::size_t>(tile);
  return {places_[i], places_[i + 1]};
}

std::vector<std::uint8_t> TiledRays::read(int station, int tile) const {
  const FilePlace place = place_of(index_of(station, tile));
  // Neither form makes a tile much larger than it is.
  if (place.bytes == 0 || place.bytes > 2 * layout_.tile_bytes() + 4096) {
    throw_damaged(station, tile, "is not where dataset 'tiles' says");
  }
  std::vector<std::uint8_t> bytes(place.bytes);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::pread(file_, bytes.data() + done, bytes.size() - done,
                                  static_cast<off_t>(place.begin + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw_damaged(station, tile, "cannot be read: " + reason_of(errno));
    if (count == 0) throw_damaged(station, tile, "is cut short");
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

void TiledRays::throw_damaged(int station, int tile, const std::string& what) const {
  throw Error(
      fmt::format("{}: tile {} of station {} {}; restore the file from a copy or pack the room "
                  "again",
                  path_.string(), tile, station, what));
}

bool TiledRays::evict_unless_used(std::int64_t tile) {
  const bool used = state_of(tile) == State::kUsed;
  states_[static_cast<std::size_t>(tile)].store(used ? State::kDecoded : State::kAbsent,
                                                std::memory_order_release);
  if (used) return false;
  const auto station = static_cast<int>(tile / layout_.tiles());
  const auto of_station = static_cast<int>(tile % layout_.tiles());
  const auto are_absent = [&](int tile_begin, int tile_end) {
    for (int other = tile_begin; other < tile_end; ++other) {
      if (state_of(index_of(station, other)) != State::kAbsent) return false;
    }
    return true;
  };
  // Offsets from the station's first ray, which begins a page. A page shared with other tiles goes
  // too if none of them is decoded.
  const auto [first, last] = layout_.bytes_of(of_station);
  std::size_t begin = first / page_bytes() * page_bytes(), end = whole_pages(last);
  if (!are_absent(layout_.tile_of(begin), of_station)) begin = whole_pages(first);
  if (!are_absent(of_station + 1, layout_.tile_of(end - 1) + 1)) {
    end = last / page_bytes() * page_bytes();
  }
  if (begin < end) {
    ::madvise(const_cast<std::uint8_t*>(rays(station)) + begin, end - begin, MADV_DONTNEED);
  }
  return true;
}

bool TiledRays::is_decoded(int station, std::size_t byte) const {
  return state_of(index_of(station, layout_.tile_of(byte))) != State::kAbsent;
}

void TiledRays::fetch(int station, std::size_t begin, std::size_t end) const {
  const int last = layout_.tile_of(end - 1);
  for (int tile = layout_.tile_of(begin); tile <= last; ++tile) {
    const std::int64_t index = index_of(station, tile);
    if (state_of(index) != State::kAbsent) continue;
    const FilePlace place = place_of(index);
    ::posix_fadvise(file_, static_cast<off_t>(place.begin), static_cast<off_t>(place.bytes),
                    POSIX_FADV_WILLNEED);
  }
}

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

TiledRaysWriter::TiledRaysWriter(Hdf5File* hdf5, const RayForm& form, int stations,
                                 PanoramaSize panorama, const TileLayout& layout)
    : hdf5_(hdf5), form_(form), layout_(layout) {
  places_.resize(2 * static_cast<std::size_t>(stations) * static_cast<std::size_t>(layout.tiles()));
  hdf5->create_encoded("rays", shape_of_rays(stations, panorama),
                       shape_of_rays(1, {layout.tile().columns, layout.tile().rows}), kTileFilter,
                       filter_values(form.kind, layout.tile()));
  hdf5->write_attribute("/", "compression", name_of(form));
}

TiledRaysWriter::Encoded TiledRaysWriter::encode(std::span<std::uint8_t> rays) const {
  Encoded tiles;
  for (int tile = 0; tile < layout_.tiles(); ++tile) {
    std::uint8_t* const rgb = rays.data() + layout_.bytes_of(tile).begin;
    tiles.push_back(encode_tile(form_, layout_.tile(), rgb));
    if (form_.kind == RayForm::Kind::kJpeg &&
        !decode_tile(form_.kind, layout_.tile(), tiles.back(), rgb)) {
      throw std::logic_error("a tile cannot be decoded that has just been encoded");
    }
  }
  return tiles;
}

void TiledRaysWriter::write(int station, const Encoded& tiles) {
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    const Shape start{static_cast<std::size_t>(station),
                      tile * static_cast<std::size_t>(layout_.tile().columns), 0, 0};
    const FilePlace place = hdf5_->write_chunk("rays", start, tiles[tile]);
    const std::size_t index = static_cast<std::size_t>(station) * tiles.size() + tile;
    places_[2 * index] = place.begin;
    places_[2 * index + 1] = place.bytes;
  }
}

void TiledRaysWriter::complete() {
  const auto tiles = static_cast<std::size_t>(layout_.tiles());
  hdf5_->write("tiles", places_, {places_.size() / 2 / tiles, tiles, 2});
}

}  // namespace raywalk
