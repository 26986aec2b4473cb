#include "core/files/nearest_word.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>

namespace raywalk {
namespace {

// Levenshtein distance: the fewest insertions, deletions and replacements that turn `a` into `b`.
// With D(i, j) the distance between the first i letters of a and the first j of b,
//   D(i, j) = min(D(i-1, j) + 1, D(i, j-1) + 1, D(i-1, j-1) + [a_i != b_j]),
// computed row by row; only one row is kept.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> nearest_word(const std::string& word,
                                        const std::vector<std::string>& candidates) {
  std::optional<std::string> nearest;
  std::size_t nearest_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : candidates) {
    // A typing error leaves most of the word intact: two swapped letters cost 2; more than a third
    // of the letters makes it another word.
    const std::size_t allowed = std::max<std::size_t>(2, candidate.size() / 3);
    // At least one letter must remain, or all one-letter columns would match each other. The
    // distance is at least the difference in length, so very long words need no table.
    if (word.size() > candidate.size() + allowed || candidate.size() > word.size() + allowed) {
      continue;
    }
    const std::size_t distance = edit_distance(word, candidate);
    if (distance > allowed || distance >= std::max(word.size(), candidate.size())) continue;
    if (distance < nearest_distance) {
      nearest = candidate;
      nearest_distance = distance;
    }
  }
  return nearest;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& candidates) {
  if (const auto nearest = nearest_word(word, candidates)) {
    return "; did you mean '" + *nearest + "'?";
  }
  std::string list;
  for (const std::string& candidate : candidates) {
    list += (list.empty() ? "" : ", ") + candidate;
  }
  return "; valid are " + list;
}

}  // namespace raywalk
