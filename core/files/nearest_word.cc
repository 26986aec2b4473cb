#include "core/files/nearest_word.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
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

constexpr std::size_t kMostListed = 8;
constexpr std::size_t kNearestListed = 3;
// Longer words, as in a file that is no configuration, are cut before they are compared.
constexpr std::size_t kLongestWord = 100;

// "speed_mm_s" of "slider.motion.speed_mm_s".
std::string last_part(const std::string& key) { return key.substr(key.rfind('.') + 1); }

std::vector<std::string> last_parts(const std::vector<std::string>& keys) {
  std::vector<std::string> parts;
  parts.reserve(keys.size());
  for (const std::string& key : keys) parts.push_back(last_part(key));
  return parts;
}

// The share of letters that differ, 0 to 1.
double unlikeness(const std::string& a, const std::string& b) {
  const std::size_t longer = std::max({a.size(), b.size(), std::size_t{1}});
  return static_cast<double>(edit_distance(a, b)) / static_cast<double>(longer);
}

// The candidates ordered by how much they resemble the word, whole or in their last part.
std::vector<std::string> by_likeness(const std::string& long_word,
                                     std::vector<std::string> candidates) {
  const std::string word = long_word.substr(0, kLongestWord);
  std::map<std::string, double> unlike;
  for (const std::string& candidate : candidates) {
    unlike[candidate] =
        std::min(unlikeness(word, candidate), unlikeness(last_part(word), last_part(candidate)));
  }
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [&](const std::string& a, const std::string& b) { return unlike.at(a) < unlike.at(b); });
  return candidates;
}

// The index of the nearest candidate, if it is near enough.
std::optional<std::size_t> nearest_index(const std::string& word,
                                         const std::vector<std::string>& candidates) {
  std::optional<std::size_t> nearest;
  std::size_t nearest_distance = std::numeric_limits<std::size_t>::max();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const std::string& candidate = candidates[i];
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
      nearest = i;
      nearest_distance = distance;
    }
  }
  return nearest;
}

}  // namespace

std::optional<std::string> nearest_word(const std::string& word,
                                        const std::vector<std::string>& candidates) {
  if (const auto whole = nearest_index(word, candidates)) return candidates[*whole];
  const auto part = nearest_index(last_part(word), last_parts(candidates));
  return part ? std::optional(candidates[*part]) : std::nullopt;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& candidates) {
  if (const auto nearest = nearest_word(word, candidates)) {
    return "; did you mean '" + *nearest + "'?";
  }
  if (candidates.size() <= kMostListed) {
    return fmt::format("; valid are {}", fmt::join(candidates, ", "));
  }
  std::vector<std::string> nearest = by_likeness(word, candidates);
  nearest.resize(kNearestListed);
  return fmt::format("; the nearest valid ones are '{}'", fmt::join(nearest, "', '"));
}

}  // namespace raywalk
