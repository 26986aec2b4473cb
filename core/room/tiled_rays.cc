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

namespace raywalk {
namespace {

// Vector loads reach a few bytes over what is asked for.
constexpr std::size_t kSlack = 16;

std::size_t page_size() {
  static const auto bytes = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  return bytes;
}

std::size_t whole_pages(std::size_t bytes) {
  return (bytes + page_size() - 1) / page_size() * page_size();
}

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

Shape shape_of_tile(const TileLayout& layout) {
  return {1, static_cast<std::size_t>(layout.tile().columns),
          static_cast<std::size_t>(layout.tile().rows), 3};
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
  hdf5.require_shape("rays", shape_of_rays(stations, panorama));
  const auto count = static_cast<std::size_t>(index_of(stations, 0));
  hdf5.require_shape(
      "tiles", {static_cast<std::size_t>(stations), static_cast<std::size_t>(layout_.tiles()), 2});
  places_ = hdf5.read<std::uint64_t>("tiles");
  states_ = std::vector<std::atomic<State>>(count);
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw Error(fmt::format("{}: {}", path_.string(), reason_of(errno)));
  // Each station begins with a page and ends with kSlack bytes that no other station has.
  stride_ = whole_pages(layout_.station_bytes() + kSlack);
  space_bytes_ = page_size() + static_cast<std::size_t>(stations) * stride_;
  void* const space = ::mmap(nullptr, space_bytes_, PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (space == MAP_FAILED) {
    const std::string reason = reason_of(errno);
    ::close(file_);
    throw Error(fmt::format("{}: no address space for {} bytes of rays: {}", path_.string(),
                            space_bytes_, reason));
  }
  space_ = static_cast<std::byte*>(space);
  first_ray_ = reinterpret_cast<const std::uint8_t*>(space_ + page_size());
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
  std::atomic<State>& state = this->state(index);
  while (true) {
    State found = state.load(std::memory_order_acquire);
    if (found == State::kBusy) {
      state.wait(found, std::memory_order_acquire);
    } else if (found != State::kAbsent) {
      state.store(State::kUsed, std::memory_order_release);
      return;
    } else if (state.compare_exchange_weak(found, State::kBusy, std::memory_order_acq_rel)) {
      break;
    }
  }
  const auto leave = [&](State now) {
    state.store(now, std::memory_order_release);
    state.notify_all();
  };
  try {
    decode(station, tile);
  } catch (...) {
    leave(State::kAbsent);
    throw;
  }
  leave(State::kUsed);
  TileCache::of_process().add(this, index);
}

void TiledRays::decode(int station, int tile) {
  auto* const out = const_cast<std::uint8_t*>(rays(station)) + layout_.bytes_of(tile).begin;
  if (!decode_tile(form_.kind, layout_.tile(), read(station, tile), out)) {
    throw_damaged(station, tile, "cannot be decoded");
  }
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
  if (state_of(tile) == State::kUsed) {
    state(tile).store(State::kDecoded, std::memory_order_release);
    return false;
  }
  state(tile).store(State::kAbsent, std::memory_order_release);
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
  std::size_t begin = first / page_size() * page_size(), end = whole_pages(last);
  if (!are_absent(layout_.tile_of(begin), of_station)) begin = whole_pages(first);
  if (!are_absent(of_station + 1, layout_.tile_of(end - 1) + 1))
    end = last / page_size() * page_size();
  if (begin < end) {
    ::madvise(const_cast<std::uint8_t*>(rays(station)) + begin, end - begin, MADV_DONTNEED);
  }
  return true;
}

bool TiledRays::is_decoded(int station, std::size_t byte) const {
  return state_of(index_of(station, layout_.tile_of(byte))) >= State::kDecoded;
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

TiledRaysWriter::TiledRaysWriter(Hdf5File* hdf5, const RayForm& form, int stations,
                                 PanoramaSize panorama, const TileLayout& layout)
    : hdf5_(hdf5), form_(form), layout_(layout) {
  places_.resize(2 * static_cast<std::size_t>(stations) * static_cast<std::size_t>(layout.tiles()));
  hdf5->create_encoded("rays", shape_of_rays(stations, panorama), shape_of_tile(layout),
                       kTileFilter, filter_values(form.kind, layout.tile()));
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
