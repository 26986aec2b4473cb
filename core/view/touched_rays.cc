#include "core/view/touched_rays.h"

#include <bit>

namespace raywalk {
namespace {

std::uintptr_t line_of(const std::uint8_t* byte) {
  return reinterpret_cast<std::uintptr_t>(byte) / TouchedRays::kLineBytes;
}

}  // namespace

TouchedRays::TouchedRays(const Room& room) : lines_(room.grid().lines.size()) {
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const LineVolume& volume = room.volume(static_cast<int>(i));
    const std::uint8_t* const last_station = volume.rays(volume.stations() - 1);
    lines_[i].first_line = line_of(volume.rays(0));
    const std::uintptr_t count =
        line_of(last_station + volume.station_bytes() - 1) - lines_[i].first_line + 1;
    lines_[i].bits = std::vector<std::atomic<std::uint64_t>>((count + 63) / 64);
  }
}

void TouchedRays::clear() {
  for (LineBits& line : lines_) {
    for (auto& bits : line.bits) bits.store(0, std::memory_order_relaxed);
  }
}

void TouchedRays::mark(int line, const std::uint8_t* first, std::size_t bytes) {
  LineBits& touched = lines_[static_cast<std::size_t>(line)];
  const std::uintptr_t last = line_of(first + bytes - 1) - touched.first_line;
  for (std::uintptr_t i = line_of(first) - touched.first_line; i <= last; ++i) {
    const std::uint64_t bit = std::uint64_t{1} << (i % 64);
    auto& bits = touched.bits[i / 64];
    // Most bits are already set, and reading is cheaper than writing.
    if ((bits.load(std::memory_order_relaxed) & bit) == 0) {
      bits.fetch_or(bit, std::memory_order_relaxed);
    }
  }
}

std::int64_t TouchedRays::bytes() const {
  std::int64_t lines = 0;
  for (const LineBits& line : lines_) {
    for (const auto& bits : line.bits) lines += std::popcount(bits.load(std::memory_order_relaxed));
  }
  return kLineBytes * lines;
}

}  // namespace raywalk
