#include "core/command_line/point_argument.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <set>

#include "core/files/number.h"

namespace raywalk {
namespace {

constexpr std::string_view kSpaces = " \t";
constexpr const char* kTypeName = "X,Z";
// "0", ",", "0".
constexpr std::size_t kMostWords = 3;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

// The names of all point options of the program's commands.
std::set<std::string> point_flags(const CLI::App& app) {
  std::set<std::string> flags;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_type_name() != kTypeName) continue;
      for (const std::string& name : option->get_lnames()) flags.insert("--" + name);
    }
  }
  return flags;
}

// How many words from `begin` on, the first of them starting with `start`, are a point; 1 if none.
std::size_t words_of_point(const std::vector<std::string>& words, std::size_t begin,
                           std::string* start) {
  std::string text = *start;
  for (std::size_t count = 1; count <= kMostWords; ++count) {
    if (parse_coordinate_pair(text)) {
      *start = text;
      return count;
    }
    if (begin + count >= words.size()) break;
    text += " " + words[begin + count];
  }
  return 1;
}

}  // namespace

std::optional<CoordinatePair> parse_coordinate_pair(std::string_view text) {
  text = trimmed(text);
  std::size_t end = text.find(',');
  if (end == std::string_view::npos) end = text.find_first_of(kSpaces);
  if (end == std::string_view::npos) return std::nullopt;
  const auto first = parse_finite_number(trimmed(text.substr(0, end)));
  const auto second = parse_finite_number(trimmed(text.substr(end + 1)));
  if (!first || !second) return std::nullopt;
  return CoordinatePair{*first, *second};
}

CLI::Option* add_point_option(CLI::App* command, const std::string& flag, std::string* text,
                              const std::string& description) {
  return command->add_option(flag, *text, description)->type_name(kTypeName);
}

std::vector<std::string> joined_points(const CLI::App& app, std::vector<std::string> arguments) {
  const std::set<std::string> flags = point_flags(app);
  std::vector<std::string> joined;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    std::string& word = arguments[i];
    const std::size_t equals = word.find('=');
    const bool is_point_flag = flags.count(word.substr(0, equals)) > 0;
    if (is_point_flag && equals != std::string::npos) {
      std::string value = word.substr(equals + 1);
      const std::size_t words = words_of_point(arguments, i, &value);
      joined.push_back(word.substr(0, equals + 1) + value);
      i += words - 1;
      continue;
    }
    joined.push_back(word);
    if (is_point_flag && i + 1 < arguments.size()) {
      std::string value = arguments[i + 1];
      i += words_of_point(arguments, i + 1, &value);
      joined.push_back(value);
    }
  }
  return joined;
}

}  // namespace raywalk
