// Numbers as people write them in tables and settings, independent of the locale.
#pragma once

#include <optional>
#include <string_view>

namespace raywalk {

// The value of a decimal number ("-1.5e3", a leading '+' allowed) that fills `text` completely;
// none when it is anything else, also for NaN, infinity and values beyond the range of double.
std::optional<double> parse_finite_number(std::string_view text);

// The same for a whole decimal number within the range of int.
std::optional<int> parse_whole_number(std::string_view text);

// The same, or a hexadecimal number as manuals of devices write them ("0x6200"); no sign there.
std::optional<int> parse_whole_or_hexadecimal_number(std::string_view text);

}  // namespace raywalk
