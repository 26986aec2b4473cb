// The parts of a file that a client asks for (RFC 9110, 14): "bytes=0-499,-500".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

inline constexpr std::size_t kMostByteRanges = 16;

// Both inclusive, first <= last < size.
struct ByteRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;

  std::uint64_t size() const { return last - first + 1; }
  friend bool operator==(const ByteRange&, const ByteRange&) = default;
};

enum class RangeAnswer {
  kWhole,         // no valid range of bytes is asked for: status 200
  kParts,         // 206
  kUnsatisfiable  // 416
};

struct RequestedRanges {
  RangeAnswer answer = RangeAnswer::kWhole;
  // Disjoint, so that an answer is never longer than the file; as requested in order, or ascending
  // where some were merged because they overlap or touch.
  std::vector<ByteRange> parts{};
};

// What the value of a Range field asks for of a file of `size` bytes. A field that is malformed,
// names another unit or more than kMostByteRanges ranges is ignored, as the RFC allows.
RequestedRanges parse_byte_ranges(std::string_view value, std::uint64_t size);

// "bytes 0-499/1234"
std::string content_range(const ByteRange& part, std::uint64_t size);

}  // namespace raywalk
