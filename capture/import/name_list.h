// Names in a message of one line.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

namespace raywalk::capture {

// "a, b, c"; beyond eight names, the first eight "and 7 more".
inline std::string name_list(std::span<const std::string> names) {
  constexpr std::size_t kMost = 8;
  const std::size_t shown = std::min(names.size(), kMost);
  std::string list = fmt::format("{}", fmt::join(names.first(shown), ", "));
  if (names.size() > shown) list += fmt::format(" and {} more", names.size() - shown);
  return list;
}

}  // namespace raywalk::capture
