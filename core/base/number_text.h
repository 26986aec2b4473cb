// Numbers as text, independent of the locale.
#pragma once

#include <string>

namespace raywalk {

// In fixed notation with exactly `decimals` digits after the point ("2.00", "-3.14"). Not-a-number
// and infinities read "nan", "inf", "-inf"; zero has no sign.
std::string fixed_number(double value, int decimals);

// The same; "–" for a value that is not finite: not measured, or not measurable.
std::string number_or_dash(double value, int decimals);

// The same as fixed_number with at most `decimals` digits and no trailing zeros ("2", "0.25",
// "-3.1").
std::string plain_number(double value, int decimals);

}  // namespace raywalk
