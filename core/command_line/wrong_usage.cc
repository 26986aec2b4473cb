#include "core/command_line/wrong_usage.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <optional>

#include "core/base/error.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

// Fewer letters begin too many words.
constexpr std::size_t kLeastPrefix = 2;

bool is_flag(const std::string& word) {
  return word.size() > 1 && word.front() == '-' && !parse_finite_number(word);
}

// "--Tolerance_Px=1" becomes "tolerance-px".
std::string flag_name(const std::string& word) {
  std::string name = word.substr(std::min(word.find_first_not_of('-'), word.size()));
  name = name.substr(0, name.find('='));
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
    return c == '_' ? '-' : static_cast<char>(std::tolower(c));
  });
  return name;
}

std::vector<std::string> long_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    names.insert(names.end(), option->get_lnames().begin(), option->get_lnames().end());
  }
  return names;
}

// A name that `name` begins, or that begins it: "gen" and "output" mean generation and out.
std::optional<std::string> named_in_part(const std::string& name,
                                         const std::vector<std::string>& names) {
  for (const std::string& other : names) {
    const std::size_t shared = std::min(name.size(), other.size());
    if (shared >= kLeastPrefix && name.compare(0, shared, other, 0, shared) == 0) return other;
  }
  return std::nullopt;
}

std::string unknown_flag(const std::string& word, const CLI::App& command) {
  std::string text = "unknown flag " + excerpt(word.substr(0, word.find('=')));
  const std::vector<std::string> names = long_names(command);
  const std::string name = flag_name(word);
  std::optional<std::string> meant = nearest_word(name, names);
  if (!meant) meant = named_in_part(name, names);
  return meant ? text + "; did you mean '--" + *meant + "'?" : text;
}

std::string unknown_command(const std::string& word, const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  std::string name = word;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return "unknown command " + excerpt(word) + suggestion(name, names);
}

// The command that was given; the program itself where there is none.
const CLI::App& given_command(const CLI::App& app) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  return given.empty() ? app : *given.front();
}

const CLI::App* command_named(const std::string& name, const CLI::App& app) {
  const auto found =
      app.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

std::string help_hint(const CLI::App& app, const CLI::App& command, const std::string& program) {
  return "; see " + program + (&command == &app ? "" : " " + command.get_name()) + " --help";
}

bool has_flag(const CLI::App& command, const std::string& word) {
  return command.get_option_no_throw(word.substr(0, word.find('='))) != nullptr;
}

// The given command if it has the flag, else the first that has; null if none has.
const CLI::App* owner_of(const std::string& flag, const CLI::App& app) {
  if (has_flag(given_command(app), flag)) return &given_command(app);
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (has_flag(*command, flag)) return command;
  }
  return nullptr;
}

// A word in front of the command, or instead of it.
std::string misplaced(const std::string& word, const CLI::App& app, const std::string& program) {
  if (is_flag(word)) {
    const CLI::App* owner = owner_of(word, app);
    if (owner == nullptr) return unknown_flag(word, app);
    return "the flag " + excerpt(word) + " goes behind its command: " + program + " " +
           owner->get_name() + " " + word;
  }
  const bool command_given = &given_command(app) != &app;
  return command_given ? "unexpected argument " + excerpt(word) : unknown_command(word, app);
}

// An option that took the next flag for its value: "--at --out v.png".
std::optional<std::string> missing_value(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_expected_max() == 0) continue;
    for (const std::string& value : option->results()) {
      if (value.rfind("--", 0) == 0 && has_flag(command, value)) {
        return option->get_name() + " needs a value, but " + excerpt(value) + " follows";
      }
    }
  }
  return std::nullopt;
}

std::string reason(const CLI::App& app, const CLI::ParseError& error, const std::string& program) {
  const CLI::App& command = given_command(app);
  if (const auto missing = missing_value(command)) return *missing;
  const std::vector<std::string> before = app.remaining();
  if (!app.get_subcommands(nullptr).empty() && !before.empty()) {
    return misplaced(before.front(), app, program);
  }
  const std::vector<std::string> extra = command.remaining();
  const auto flag = std::find_if(extra.begin(), extra.end(), is_flag);
  if (flag != extra.end()) return unknown_flag(*flag, command);
  if (!extra.empty() && dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    return "unexpected argument " + excerpt(extra.front());
  }
  return error.what();
}

}  // namespace

void require_double_dashes(const CLI::App& app, const std::vector<std::string>& arguments,
                           const std::string& program) {
  const CLI::App* command = nullptr;
  for (const std::string& word : arguments) {
    if (command == nullptr) {
      command = command_named(word, app);
      continue;
    }
    const bool single_dash = word.size() > 2 && word[0] == '-' && word[1] != '-';
    if (single_dash && has_flag(*command, "-" + word)) {
      throw UsageError(unknown_flag(word, *command) + help_hint(app, *command, program));
    }
  }
}

std::string wrong_usage(const CLI::App& app, const CLI::ParseError& error,
                        const std::string& program) {
  return reason(app, error, program) + help_hint(app, given_command(app), program);
}

}  // namespace raywalk
