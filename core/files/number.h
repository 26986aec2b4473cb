// Parsing numbers in tables and settings, independent of the locale.
#pragma once

#include <optional>
#include <string_view>

namespace raywalk {

// The value if all of `text` is a decimal number ("-1.5e3", a leading '+' is allowed); none
// otherwise, also for NaN, infinity and values beyond the range of double.
std::optional<double> parse_finite_number(std::string_view text);

// The same for a decimal integer within the range of int.
std::optional<int> parse_whole_number(std::string_view text);

// The same, or an unsigned hexadecimal number as in device manuals ("0x6200").
std::optional<int> parse_whole_or_hexadecimal_number(std::string_view text);

}  // namespace raywalk
