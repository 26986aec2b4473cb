// The words of enumerators, for files, databases and messages.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string_view>

namespace raywalk::capture {

// The word of an enumerator; `words` are in the order of the enumeration, which counts from 0.
template <typename Enum, std::size_t kCount>
constexpr std::string_view word_of(Enum value, const char* const (&words)[kCount]) {
  const auto index = static_cast<std::size_t>(value);
  if (index >= kCount) throw std::logic_error("an enumerator without a word");
  return words[index];
}

}  // namespace raywalk::capture
