// Numbers as text, independent of the locale.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace raywalk {

// In fixed notation with exactly `decimals` digits after the point ("2.00", "-3.14"). Not-a-number
// and infinities read "nan", "inf", "-inf"; zero has no sign.
std::string fixed_number(double value, int decimals);

// The same; "–" for a value that is not finite: not measured, or not measurable.
std::string number_or_dash(double value, int decimals);

// The same as fixed_number with at most `decimals` digits and no trailing zeros ("2", "0.25",
// "-3.1").
std::string plain_number(double value, int decimals);

// A length as in the options of the commands: "4.27 mm"; from a metre on whole millimetres.
std::string mm_text(double metres);

// For an option --...-mm that is to be at least `metres` > 0: the next larger number of two digits.
std::string mm_at_least(double metres);

// "1 line", "3 lines": the count and the noun, with an s unless the count is 1.
std::string counted(std::size_t count, std::string_view noun);

}  // namespace raywalk
