// Counts how much of a room's rays a view reads: the distinct 64-byte cache lines that its samples
// lie in. Other bytes that the processor or the disk fetches (the rest of a vector load,
// read-ahead) do not count.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

class TouchedRays {
 public:
  static constexpr int kLineBytes = 64;

  // One bit for every line of the room's rays. The room must outlive this.
  explicit TouchedRays(const Room& room);

  // Resets the count. Not thread-safe.
  void clear();
  // Counts `bytes` (at least 1) bytes from `first` on, in the rays of `line`; from any thread.
  void mark(int line, const std::uint8_t* first, std::size_t bytes);
  // Bytes of all cache lines marked since the last clear().
  std::int64_t bytes() const;

 private:
  struct LineBits {
    std::uintptr_t first_line = 0;  // address of the volume's first byte / kLineBytes
    std::vector<std::atomic<std::uint64_t>> bits;
  };
  std::vector<LineBits> lines_;
};

}  // namespace raywalk
