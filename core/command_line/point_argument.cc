#include "core/command_line/point_argument.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include "core/files/words.h"

namespace raywalk {
namespace {

constexpr std::string_view kSpaces = " \t";
constexpr const char* kPlanType = "X,Z";
constexpr const char* kPlanOrSpaceType = "X[,Y],Z";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

// The point options of the program's commands, by name: the most numbers of each.
std::map<std::string, std::size_t> point_flags(const CLI::App& app) {
  std::map<std::string, std::size_t> flags;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    for (const CLI::Option* option : command->get_options()) {
      const std::string type = option->get_type_name();
      if (type != kPlanType && type != kPlanOrSpaceType) continue;
      const std::size_t numbers = type == kPlanType ? 2 : 3;
      for (const std::string& name : option->get_lnames()) {
        std::size_t& most = flags["--" + name];
        most = std::max(most, numbers);
      }
    }
  }
  return flags;
}

// How many words from `begin` on, the first of them starting with `start`, are the longest point of
// at most `most_numbers`; 1 if none.
std::size_t words_of_point(const std::vector<std::string>& words, std::size_t begin,
                           std::size_t most_numbers, std::string* start) {
  std::string text = *start;
  std::size_t found = 1;
  const std::size_t most_words = 2 * most_numbers - 1;  // "0", ",", "0"
  for (std::size_t count = 1; count <= most_words; ++count) {
    const std::size_t numbers = parse_point(text).size();
    if (numbers > 0 && numbers <= most_numbers) {
      *start = text;
      found = count;
    }
    if (begin + count >= words.size()) break;
    text += " " + words[begin + count];
  }
  return found;
}

// The text before the first comma, or spaces where there is none, and what follows it.
std::optional<std::pair<std::string_view, std::string_view>> split_first(std::string_view text) {
  std::size_t end = text.find(',');
  if (end == std::string_view::npos) end = text.find_first_of(kSpaces);
  if (end == std::string_view::npos) return std::nullopt;
  return std::pair(trimmed(text.substr(0, end)), trimmed(text.substr(end + 1)));
}

}  // namespace

std::vector<double> parse_point(std::string_view text) {
  constexpr std::size_t kMostNumbers = 3;
  std::vector<double> numbers;
  text = trimmed(text);
  while (numbers.size() < kMostNumbers) {
    const auto parts = split_first(text);
    const auto number = parse_finite_number(parts ? parts->first : text);
    if (!number) return {};
    numbers.push_back(*number);
    if (!parts) break;
    text = parts->second;
    if (numbers.size() == kMostNumbers) return {};
  }
  return numbers.size() < 2 ? std::vector<double>() : numbers;
}

std::optional<CoordinatePair> parse_coordinate_pair(std::string_view text) {
  const std::vector<double> numbers = parse_point(text);
  if (numbers.size() != 2) return std::nullopt;
  return CoordinatePair{numbers[0], numbers[1]};
}

CLI::Option* add_point_option(CLI::App* command, const std::string& flag, std::string* text,
                              const std::string& description, PointKind kind) {
  return command->add_option(flag, *text, description)
      ->type_name(kind == PointKind::kPlan ? kPlanType : kPlanOrSpaceType);
}

std::vector<std::string> joined_points(const CLI::App& app, std::vector<std::string> arguments) {
  const std::map<std::string, std::size_t> flags = point_flags(app);
  std::vector<std::string> joined;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    std::string& word = arguments[i];
    const std::size_t equals = word.find('=');
    const auto flag = flags.find(word.substr(0, equals));
    const bool is_point_flag = flag != flags.end();
    if (is_point_flag && equals != std::string::npos) {
      std::string value = word.substr(equals + 1);
      const std::size_t words = words_of_point(arguments, i, flag->second, &value);
      joined.push_back(word.substr(0, equals + 1) + value);
      i += words - 1;
      continue;
    }
    joined.push_back(word);
    if (is_point_flag && i + 1 < arguments.size()) {
      std::string value = arguments[i + 1];
      i += words_of_point(arguments, i + 1, flag->second, &value);
      joined.push_back(value);
    }
  }
  return joined;
}

}  // namespace raywalk
