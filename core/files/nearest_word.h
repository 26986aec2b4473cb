// "Did you mean ...?" for misspelt keys, columns and choices.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace raywalk {

// The candidate closest to `word` in edit distance, the first of equally close ones; none if no
// candidate is close enough to be a typing error. A dotted key may also stand in the wrong group or
// in none: its last part is then compared ("speed_mm_s", "slider.motion.speed_mm_s").
std::optional<std::string> nearest_word(const std::string& word,
                                        const std::vector<std::string>& candidates);

// The end of a message about an unknown word: "; did you mean 'x'?" for the nearest candidate, else
// "; valid are a, b, c", or, of more than eight candidates, "; the nearest valid ones are 'a', 'b',
// 'c'", the nearest first.
std::string suggestion(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace raywalk
