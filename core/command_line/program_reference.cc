#include "core/command_line/program_reference.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <iterator>
#include <optional>
#include <string_view>

#include "core/command_line/config_option.h"

namespace raywalk {
namespace {

// CLI11's name of the type of text.
constexpr std::string_view kTextType = "TEXT";
// Between what a value may be: words in small letters, types in capitals ("sweep|flow",
// "NUMBER|auto").
constexpr char kOr = '|';

// What is between the first `begin` and the first `end` behind it; empty if there is none.
std::string between(const std::string& text, char begin, char end) {
  const std::size_t first = text.find(begin);
  const std::size_t last = text.find(end, first == std::string::npos ? first : first + 1);
  if (last == std::string::npos) return "";
  return text.substr(first + 1, last - first - 1);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

// The type name of an option is that of its value and what its checks say of themselves:
// "TEXT:{png,jpg}", "INT:INT in [0 - 1024]".
void read_type(const std::string& type_name, OptionReference* option) {
  const std::size_t colon = std::min(type_name.find(':'), type_name.size());
  const std::string checks = type_name.substr(colon);
  option->value = type_name.substr(0, colon);
  option->choices = split(between(checks, '{', '}'), ',');
  option->limits = between(checks, '[', ']');
  if (const std::optional<ConfigKind> kind = config_kind_of(option->value)) {
    option->choices = shipped_config_names(*kind);
    option->takes_path = true;
  } else if (option->choices.empty()) {
    option->takes_path = option->value == kTextType;
    for (const std::string& word : split(option->value, kOr)) {
      if (std::islower(static_cast<unsigned char>(word.front())) != 0) {
        option->choices.push_back(word);
      }
    }
  }
}

OptionReference described(const CLI::Option& option) {
  OptionReference reference;
  for (const std::string& name : option.get_snames()) reference.flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) reference.flags.push_back("--" + name);
  reference.required = option.get_required();
  reference.group = option.get_group();
  reference.description = option.get_description();
  if (option.get_expected_max() == 0) return reference;
  read_type(option.get_type_name(), &reference);
  if (reference.flags.empty()) reference.value = option.get_name();
  reference.default_value = option.get_default_str();
  reference.is_list = option.get_delimiter() != '\0';
  reference.repeats = option.get_expected_max() > 1;
  return reference;
}

std::vector<OptionReference> options_of(const CLI::App& app) {
  std::vector<OptionReference> options;
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty()) options.push_back(described(*option));
  }
  return options;
}

}  // namespace

ProgramReference reference_of(const CLI::App& app) {
  ProgramReference program{
      app.get_name(), app.version(), app.get_description(), options_of(app), {}, app.get_footer()};
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    program.commands.push_back({command->get_name(), command->get_description(),
                                options_of(*command), command->get_footer()});
  }
  return program;
}

std::vector<OptionReference> arguments_among(const std::vector<OptionReference>& options) {
  std::vector<OptionReference> arguments;
  std::copy_if(options.begin(), options.end(), std::back_inserter(arguments),
               [](const OptionReference& option) { return option.flags.empty(); });
  return arguments;
}

}  // namespace raywalk
