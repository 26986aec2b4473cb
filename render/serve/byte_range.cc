#include "render/serve/byte_range.h"

#include <algorithm>
#include <regex>

namespace raywalk::render {

std::optional<ByteRange> parse_byte_range(const std::string& value, std::uint64_t size) {
  // More digits than a number of 64 bits may have are no range of any file.
  static const std::regex kForm("bytes=(?:([0-9]{1,18})-([0-9]{0,18})|-([0-9]{1,18}))");
  std::smatch found;
  if (!std::regex_match(value, found, kForm)) return std::nullopt;
  const auto number = [&](int group) { return std::stoull(found[group].str()); };
  if (found[3].matched) {  // the last bytes
    const std::uint64_t count = std::min<std::uint64_t>(number(3), size);
    return count == 0 ? ByteRange{1, 0} : ByteRange{size - count, size - 1};
  }
  const std::uint64_t first = number(1);
  if (first >= size) return ByteRange{1, 0};
  if (found[2].length() == 0) return ByteRange{first, size - 1};
  if (number(2) < first) return std::nullopt;
  return ByteRange{first, std::min<std::uint64_t>(number(2), size - 1)};
}

}  // namespace raywalk::render
