#include "render/view/point_argument.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <regex>

#include "core/files/words.h"

namespace raywalk::render {
namespace {

constexpr const char* kPlanType = "X,Z";
constexpr const char* kPlanOrSpaceType = "X[,Y],Z";
constexpr const char* kBetween = ", \t";

// The most numbers of the point option of that name; 0 where there is none.
std::size_t most_numbers(const CLI::App& app, const std::string& flag) {
  std::size_t most = 0;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    const CLI::Option* option = command->get_option_no_throw(flag);
    const std::string type = option == nullptr ? "" : option->get_type_name();
    if (type == kPlanOrSpaceType) return 3;
    if (type == kPlanType) most = 2;
  }
  return most;
}

std::size_t count_numbers(const std::string& text) {
  std::size_t count = 0;
  for (std::size_t end = 0, begin = 0;
       (begin = text.find_first_not_of(kBetween, end)) < text.size();
       end = std::min(text.find_first_of(kBetween, begin), text.size())) {
    ++count;
  }
  return count;
}

bool may_be_in_point(const std::string& word) {
  return word.find_first_not_of("0123456789+-.eE,") == std::string::npos &&
         word.find_first_of("0123456789,") != std::string::npos;
}

}  // namespace

std::vector<double> parse_point(std::string_view text) {
  static const std::regex kForm(
      "[ \t]*([^, \t]+)(?:[ \t]*,[ \t]*|[ \t]+)([^, \t]+)"
      "(?:(?:[ \t]*,[ \t]*|[ \t]+)([^, \t]+))?[ \t]*");
  constexpr std::size_t kLongest = 200;
  std::cmatch found;
  if (text.size() > kLongest ||
      !std::regex_match(text.data(), text.data() + text.size(), found, kForm)) {
    return {};
  }
  std::vector<double> numbers;
  for (std::size_t i = 1; i < found.size() && found[i].matched; ++i) {
    const auto number = parse_finite_number(found[i].str());
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

CLI::Option* add_point_option(CLI::App* command, const std::string& flag, std::string* text,
                              const std::string& description, PointKind kind) {
  return command->add_option(flag, *text, description)
      ->type_name(kind == PointKind::kPlan ? kPlanType : kPlanOrSpaceType);
}

std::vector<std::string> joined_points(const CLI::App& app,
                                       const std::vector<std::string>& arguments) {
  std::vector<std::string> joined;
  std::size_t most = 0;        // of the point that the last word of `joined` begins; 0: of none
  bool value_follows = false;  // the last word is the flag alone
  for (const std::string& word : arguments) {
    if (value_follows) {
      joined.push_back(word);
      value_follows = false;
    } else if (most > 0 && may_be_in_point(word) &&
               count_numbers(joined.back()) + count_numbers(word) <= most) {
      joined.back() += " " + word;
    } else {
      joined.push_back(word);
      most = most_numbers(app, word.substr(0, word.find('=')));
      value_follows = most > 0 && word.find('=') == std::string::npos;
    }
  }
  return joined;
}

}  // namespace raywalk::render
