#include "core/room/tiled_rays.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <system_error>
#include <vector>

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

// Memory that reads as 0 and is taken from the system page by page, as it is written to.
std::byte* reserve(std::size_t bytes, const std::filesystem::path& file) {
  void* const space = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (space == MAP_FAILED) {
    throw Error(fmt::format("{}: no address space for {} bytes of rays: {}", file.string(), bytes,
                            reason_of(errno)));
  }
  return static_cast<std::byte*>(space);
}

RayForm form_of(const Hdf5File& hdf5) {
  const std::string name = hdf5.text_attribute(kCompressionAttribute).value_or("");
  try {
    const RayForm form = ray_form_from_name(name);
    if (form.compressed()) return form;
  } catch (const UsageError&) {  // said below, where the file is known
  }
  throw Error(fmt::format("{}: its compression '{}' is unknown; use a newer Raywalk",
                          hdf5.path().string(), excerpt(name)));
}

int tile_columns_of(const Hdf5File& hdf5, PanoramaSize panorama) {
  const std::vector<std::int32_t> columns = hdf5.read_int32("tile_columns");
  if (columns.size() == 1 && columns[0] >= 1 && columns[0] <= panorama.width) return columns[0];
  throw Error(hdf5.path().string() + ": dataset 'tile_columns' is not a number of columns");
}

}  // namespace

std::shared_ptr<TiledRays> TiledRays::open(const Hdf5File& hdf5, int stations,
                                           PanoramaSize panorama) {
  std::shared_ptr<TiledRays> rays(new TiledRays());
  rays->path_ = hdf5.path();
  rays->stations_ = stations;
  rays->form_ = form_of(hdf5);
  rays->layout_ = TileLayout(panorama, tile_columns_of(hdf5, panorama));
  const auto count = static_cast<std::size_t>(stations);
  require_shape(hdf5.shape_of("rays"),
                std::array{count, static_cast<std::size_t>(panorama.width),
                           static_cast<std::size_t>(panorama.height), std::size_t{3}},
                "rays", hdf5.path());
  rays->table_ = MappedDataset::open(hdf5.path(), "tiles", ElementType::kUint64);
  require_shape(rays->table_.shape(),
                std::array{count, static_cast<std::size_t>(rays->layout_.tiles()) + 1}, "tiles",
                hdf5.path());
  rays->file_ = ::open(hdf5.path().c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (rays->file_ < 0 || ::fstat(rays->file_, &status) != 0) {
    throw Error(fmt::format("{}: {}", hdf5.path().string(), reason_of(errno)));
  }
  rays->file_bytes_ = static_cast<std::uint64_t>(status.st_size);
  rays->reserve_memory();
  return rays;
}

void TiledRays::reserve_memory() {
  // Each station begins with a page and ends with kSlack bytes that no other station has.
  stride_ = whole_pages(layout_.station_bytes() + kSlack);
  space_bytes_ = page_size() + static_cast<std::size_t>(stations_) * stride_;
  space_ = reserve(space_bytes_, path_);
  first_ray_ = reinterpret_cast<const std::uint8_t*>(space_ + page_size());
  words_bytes_ = sizeof(*words_) * static_cast<std::size_t>(index_of(stations_, 0));
  words_ = reinterpret_cast<std::uint64_t*>(reserve(words_bytes_, path_));
}

TiledRays::~TiledRays() {
  TileCache::of_process().forget(this);
  if (words_ != nullptr) ::munmap(words_, words_bytes_);
  if (space_ != nullptr) ::munmap(space_, space_bytes_);
  if (file_ >= 0) ::close(file_);
}

std::uint64_t TiledRays::word_of(std::int64_t tile) const {
  return std::atomic_ref(words_[tile]).load(std::memory_order_acquire);
}

void TiledRays::require(int station, std::size_t begin, std::size_t end) {
  const std::uint64_t epoch = TileReading::epoch_of_thread();
  const int first = layout_.tile_of(begin - std::min(begin, kSlack));
  const int last = layout_.tile_of(end - 1 + kSlack);
  std::int64_t hits = 0;
  for (int tile = first; tile <= last; ++tile) {
    if (word_of(index_of(station, tile)) >= epoch) {
      ++hits;
    } else {
      bring(station, tile);
    }
  }
  TileReading::count_hits(hits);
}

void TiledRays::bring(int station, int tile) {
  const std::int64_t index = index_of(station, tile);
  const std::atomic_ref word(words_[index]);
  while (true) {
    std::uint64_t found = word.load(std::memory_order_acquire);
    if (found >= TileCache::kFirstEpoch) {
      const std::uint64_t now = TileCache::of_process().epoch();
      if (!word.compare_exchange_weak(found, now, std::memory_order_acq_rel)) continue;
      TileReading::count_hits(1);
      return;
    }
    if (found == TileCache::kBusy) {
      word.wait(TileCache::kBusy, std::memory_order_acquire);
      continue;
    }
    if (word.compare_exchange_weak(found, TileCache::kBusy, std::memory_order_acq_rel)) break;
  }
  try {
    decode(station, tile);
  } catch (...) {
    word.store(TileCache::kAbsent, std::memory_order_release);
    word.notify_all();
    throw;
  }
  word.store(TileCache::of_process().epoch(), std::memory_order_release);
  word.notify_all();
  TileCache::of_process().add(this, index, layout_.size_of(tile).bytes());
}

void TiledRays::decode(int station, int tile) {
  auto* const out = const_cast<std::uint8_t*>(rays(station)) + layout_.begin_of(tile);
  if (!decode_tile(form_.kind, layout_.size_of(tile), read(station, tile), out)) {
    throw_damaged(station, tile, "cannot be decoded");
  }
}

TiledRays::FileBytes TiledRays::place_of(int station, int first_tile, int last_tile) const {
  const auto* ends =
      static_cast<const std::uint64_t*>(table_.data()) +
      static_cast<std::size_t>(station) * (static_cast<std::size_t>(layout_.tiles()) + 1);
  return {ends[first_tile], ends[last_tile + 1]};
}

std::span<const std::uint8_t> TiledRays::read(int station, int tile) const {
  thread_local std::vector<std::uint8_t> bytes;
  const auto [begin, end] = place_of(station, tile, tile);
  // Neither form makes a tile much larger than it is.
  const std::size_t most = 2 * layout_.size_of(tile).bytes() + 4096;
  if (begin >= end || end > file_bytes_ || end - begin > most) {
    throw_damaged(station, tile, "is not where dataset 'tiles' says");
  }
  bytes.resize(static_cast<std::size_t>(end - begin));
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count =
        ::pread(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(begin + done));
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

bool TiledRays::evict(std::int64_t tile, std::uint64_t word) {
  const auto station = static_cast<int>(tile / layout_.tiles());
  const auto of_station = static_cast<int>(tile % layout_.tiles());
  const auto take = [&](std::int64_t index, std::uint64_t expected) {
    return std::atomic_ref(words_[index])
        .compare_exchange_strong(expected, TileCache::kBusy, std::memory_order_acq_rel);
  };
  const auto take_absent = [&](std::int64_t index) {
    return take(index, TileCache::kAbsent) || take(index, TileCache::kFetched);
  };
  const auto leave = [&](std::int64_t index) {
    const std::atomic_ref left(words_[index]);
    left.store(TileCache::kAbsent, std::memory_order_release);
    left.notify_all();
  };
  if (!take(tile, word)) return false;
  // Offsets from the mapping, which begins with a page.
  const auto first =
      static_cast<std::size_t>(reinterpret_cast<const std::byte*>(rays(station)) - space_);
  std::size_t begin = first + layout_.begin_of(of_station);
  std::size_t end = first + layout_.end_of(of_station);
  // A page shared with one neighbour goes too if that one is not decoded, nor being decoded.
  const std::size_t first_page = begin / page_size() * page_size();
  const bool with_left = begin != first_page && of_station > 0 &&
                         first + layout_.begin_of(of_station - 1) <= first_page &&
                         take_absent(tile - 1);
  const std::size_t last_page = whole_pages(end);
  const bool with_right = end != last_page && of_station + 1 < layout_.tiles() &&
                          first + layout_.end_of(of_station + 1) >= last_page &&
                          take_absent(tile + 1);
  begin = with_left ? first_page : whole_pages(begin);
  end =
      with_right || of_station + 1 == layout_.tiles() ? last_page : end / page_size() * page_size();
  if (begin < end) ::madvise(space_ + begin, end - begin, MADV_DONTNEED);
  if (with_left) leave(tile - 1);
  if (with_right) leave(tile + 1);
  leave(tile);
  return true;
}

bool TiledRays::is_fetched(int station, std::size_t byte) const {
  return word_of(index_of(station, layout_.tile_of(byte))) != TileCache::kAbsent;
}

void TiledRays::fetch(int station, std::size_t begin, std::size_t end) const {
  const int last = layout_.tile_of(end - 1);
  for (int tile = layout_.tile_of(begin); tile <= last; ++tile) {
    const auto is_wanted = [&](int other) {
      return word_of(index_of(station, other)) == TileCache::kAbsent;
    };
    if (!is_wanted(tile)) continue;
    const int from = tile;
    while (tile < last && is_wanted(tile + 1)) ++tile;
    for (int asked = from; asked <= tile; ++asked) {
      std::uint64_t absent = TileCache::kAbsent;
      std::atomic_ref(words_[index_of(station, asked)])
          .compare_exchange_strong(absent, TileCache::kFetched, std::memory_order_acq_rel);
    }
    const auto [first_byte, end_byte] = place_of(station, from, tile);
    if (first_byte >= end_byte) continue;  // damaged; decoding will tell
    ::posix_fadvise(file_, static_cast<off_t>(first_byte),
                    static_cast<off_t>(end_byte - first_byte), POSIX_FADV_WILLNEED);
  }
}

}  // namespace raywalk
