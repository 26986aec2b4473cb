// How much of a room's rays a view reads: the distinct 64-byte lines of memory that its samples lie
// in. What the processor or the disk fetches besides (a vector load's other bytes, read-ahead) does
// not count.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/room/room.h"

namespace raywalk::render {

class TouchedRays {
 public:
  static constexpr int kLineBytes = 64;

  // One bit for every line of the room's rays. The room must outlive this.
  explicit TouchedRays(const Room& room);

  // Forgets all. Not while others mark.
  void clear();
  // Counts `bytes` (at least 1) bytes from `first` on, in the rays of `line`; from any thread.
  void mark(int line, const std::uint8_t* first, std::size_t bytes);
  // Of all lines marked since the last clear().
  std::int64_t bytes() const;

 private:
  struct LineBits {
    std::uintptr_t first_line = 0;  // address of the volume's first byte / kLineBytes
    std::vector<std::atomic<std::uint64_t>> bits;
  };
  std::vector<LineBits> lines_;
};

}  // namespace raywalk::render
