// "Did you mean ...?" for misspelt keys, columns and choices.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace raywalk {

// The candidate closest to `word` in edit distance, the first of equally close ones; none if no
// candidate is close enough to be a typing error.
std::optional<std::string> nearest_word(const std::string& word,
                                        const std::vector<std::string>& candidates);

// "; did you mean 'x'?" for the nearest candidate, else "; valid are a, b, c": the end of a message
// about an unknown word.
std::string suggestion(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace raywalk
