// UTF-8 by table 3-7 of the Unicode standard.
#pragma once

#include <cstddef>
#include <string_view>

namespace raywalk {

// Length in bytes of the UTF-8 character at the front of `text`, which must not be empty; 0 if
// there is none.
std::size_t utf8_length(std::string_view text);

// Whether `text` is the beginning of a UTF-8 character that goes on after it.
bool is_part_of_utf8(std::string_view text);

// The code point of the UTF-8 character that `text` consists of.
char32_t utf8_code_point(std::string_view text);

}  // namespace raywalk
