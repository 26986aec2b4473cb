// The part of a file that a client asks for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace raywalk::render {

// Bytes first to last; none where first is beyond last.
struct ByteRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

// What the value of a Range field asks for of content of `size` bytes (RFC 9110, 14.1.2). None
// where it has to be ignored: it is malformed, of another unit, or asks for several ranges. first
// is beyond last where the content has no such byte.
std::optional<ByteRange> parse_byte_range(const std::string& value, std::uint64_t size);

}  // namespace raywalk::render
