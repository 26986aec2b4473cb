// Words of tables, settings and command lines: numbers, and what a misspelt word may mean.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

// The value if all of `text` is a decimal number ("-1.5e3", a leading '+' is allowed) in any
// locale; none otherwise, also for NaN, infinity and values beyond the range of double.
std::optional<double> parse_finite_number(std::string_view text);

// The same for a decimal integer within the range of int.
std::optional<int> parse_whole_number(std::string_view text);

// The same, or an unsigned hexadecimal number as in device manuals ("0x6200").
std::optional<int> parse_whole_or_hexadecimal_number(std::string_view text);

// The candidate closest to `word` in edit distance, the first of equally close ones; none if no
// candidate is close enough to be a typing error. The end of one may be missing, as "yaw" of
// "yaw-deg". A dotted key may also stand in the wrong group or in none: its last part is then
// compared ("speed_mm_s", "slider.motion.speed_mm_s").
std::optional<std::string> nearest_word(const std::string& word,
                                        const std::vector<std::string>& candidates);

// The end of a message about an unknown word: "; did you mean 'x'?" for the nearest candidate, else
// "; valid are a, b, c", or, of more than eight candidates, "; the nearest valid ones are 'a', 'b',
// 'c'", the nearest first.
std::string suggestion(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace raywalk
