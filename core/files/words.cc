#include "core/files/words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <system_error>
#include <utility>

namespace raywalk {
namespace {

constexpr std::size_t kMostListed = 8;
// Longer words, as in a file that is no configuration, are cut before they are compared.
constexpr std::size_t kLongestWord = 100;

// std::from_chars is exact and ignores the locale.
template <typename Number, typename... Base>
std::optional<Number> parse_all(std::string_view text, Base... base) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base...);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Which std::from_chars does not accept.
std::string_view without_plus(std::string_view text) {
  return text.starts_with('+') && !text.starts_with("+-") ? text.substr(1) : text;
}

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

// "yaw" is "yaw_deg" without its unit.
bool is_without_end(const std::string& word, const std::string& candidate) {
  return !word.empty() && candidate.starts_with(word) &&
         std::string("-_").find(candidate.substr(word.size(), 1)) != std::string::npos;
}

// How little a candidate resembles the word: the fraction of the letters that differ, and 1 more
// where that is no typing error.
double unlikeness(const std::string& word, const std::string& candidate) {
  const std::size_t distance = edit_distance(word, candidate);
  const std::size_t longer = std::max({word.size(), candidate.size(), std::size_t{1}});
  // A typing error leaves most of the word intact: two swapped letters cost 2; more than a third of
  // the letters makes it another word. One letter must remain, or all one-letter columns would
  // match each other.
  const std::size_t allowed = std::max<std::size_t>(2, candidate.size() / 3);
  const bool is_other = distance > allowed || distance >= longer;
  return (is_other ? 1.0 : 0.0) + static_cast<double>(distance) / static_cast<double>(longer);
}

// "speed_mm_s" of "slider.motion.speed_mm_s".
std::string last_part(const std::string& key) { return key.substr(key.rfind('.') + 1); }

// The candidates with their unlikeness, whole or in their last part; the nearest first.
std::vector<std::pair<double, std::string>> ranked(const std::string& long_word,
                                                   const std::vector<std::string>& candidates) {
  const std::string word = long_word.substr(0, kLongestWord);
  std::vector<std::pair<double, std::string>> ranked;
  ranked.reserve(candidates.size());
  for (const std::string& candidate : candidates) {
    ranked.emplace_back(
        std::min(unlikeness(word, candidate), unlikeness(last_part(word), last_part(candidate))),
        candidate);
  }
  const auto goes_on = [&](const std::pair<double, std::string>& candidate) {
    return is_without_end(last_part(word), last_part(candidate.second));
  };
  if (std::ranges::count_if(ranked, goes_on) == 1) {
    std::ranges::find_if(ranked, goes_on)->first = 0.0;
  }
  std::ranges::stable_sort(ranked, {}, &std::pair<double, std::string>::first);
  return ranked;
}

}  // namespace

std::optional<double> parse_finite_number(std::string_view text) {
  const auto value = parse_all<double>(without_plus(text));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<int> parse_whole_number(std::string_view text) {
  return parse_all<int>(without_plus(text));
}

std::optional<int> parse_whole_or_hexadecimal_number(std::string_view text) {
  if (!text.starts_with("0x") && !text.starts_with("0X")) return parse_whole_number(text);
  const auto value = parse_all<unsigned>(text.substr(2), 16);  // reads no sign
  if (!value || *value > unsigned{std::numeric_limits<int>::max()}) return std::nullopt;
  return static_cast<int>(*value);
}

std::optional<std::string> nearest_word(const std::string& word,
                                        const std::vector<std::string>& candidates) {
  const auto nearest = ranked(word, candidates);
  if (nearest.empty() || nearest.front().first >= 1.0) return std::nullopt;
  return nearest.front().second;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& candidates) {
  if (candidates.empty()) return "";
  if (const auto meant = nearest_word(word, candidates)) {
    return "; did you mean '" + *meant + "'?";
  }
  if (candidates.size() <= kMostListed) {
    return fmt::format("; valid are {}", fmt::join(candidates, ", "));
  }
  const auto nearest = ranked(word, candidates);
  return fmt::format("; the nearest valid ones are '{}', '{}', '{}'", nearest[0].second,
                     nearest[1].second, nearest[2].second);
}

}  // namespace raywalk
