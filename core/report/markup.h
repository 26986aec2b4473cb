// Text inside HTML and SVG.
#pragma once

#include <string>
#include <string_view>

namespace raywalk {

// Escapes `text` for use between tags and in quoted attributes of HTML and XML: the five special
// characters become references; control characters and bytes that are not UTF-8 are shown as
// escaped() shows them (escaped.h), so that any file name keeps a page well-formed and on one line.
std::string escape_markup(std::string_view text);

// A number in fixed notation with exactly `decimals` digits after the point ("2.00", "-3.14"),
// independent of the locale. Not-a-number and infinities read "nan", "inf", "-inf"; zero has no
// sign.
std::string fixed_number(double value, int decimals);

// The same; "–" for a value that is not finite: not measured, or not measurable.
std::string number_or_dash(double value, int decimals);

// The same as fixed_number with at most `decimals` digits and no trailing zeros ("2", "0.25",
// "-3.1").
std::string plain_number(double value, int decimals);

}  // namespace raywalk
