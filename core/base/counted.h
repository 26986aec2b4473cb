// Numbers of things in text for people.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace raywalk {

// "1 line", "3 lines": the count and the noun, with an s unless the count is 1.
inline std::string counted(std::size_t count, std::string_view noun) {
  return std::to_string(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

}  // namespace raywalk
