#include "core/command_line/wrong_usage.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

#include "core/base/error.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

bool is_flag(const std::string& word) {
  return word.size() > 1 && word.front() == '-' && !parse_finite_number(word);
}

bool has_flag(const CLI::App& command, const std::string& word) {
  return command.get_option_no_throw(word.substr(0, word.find('='))) != nullptr;
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// The command that was given; the program itself where there is none.
const CLI::App& given_command(const CLI::App& app) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  return given.empty() ? app : *given.front();
}

std::string help_hint(const CLI::App& app, const CLI::App& command) {
  const std::string name = &command == &app ? "" : " " + command.get_name();
  return "; see " + app.get_name() + name + " --help";
}

std::string unknown_flag(const std::string& word, const CLI::App& command) {
  const std::string written = word.substr(0, word.find('='));
  // "--Tolerance_Px" means "tolerance-px".
  std::string name = lower_case(written.substr(written.find_first_not_of('-')));
  std::replace(name.begin(), name.end(), '_', '-');
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    names.insert(names.end(), option->get_lnames().begin(), option->get_lnames().end());
  }
  // Also the beginning of a name, or more than one: "gen" and "output" mean method and out.
  auto meant = nearest_word(name, names);
  for (const std::string& other : names) {
    const bool begins = name.size() > 1 && (name.starts_with(other) || other.starts_with(name));
    if (!meant && begins) meant = other;
  }
  const std::string text = "unknown flag " + excerpt(written);
  return meant ? text + "; did you mean '--" + *meant + "'?" : text;
}

std::string unknown_command(const std::string& word, const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  return "unknown command " + excerpt(word) + suggestion(lower_case(word), names);
}

std::string reason(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = given_command(app);
  // An option that took the next flag for its value: "--at --out v.png".
  for (const CLI::Option* option : command.get_options()) {
    if (option->results().empty() || option->get_expected_max() == 0) continue;
    const std::string& value = option->results().front();
    if (value.starts_with("--") && has_flag(command, value)) {
      return option->get_name() + " needs a value, but " + excerpt(value) + " follows";
    }
  }
  // In front of the command, or without one.
  const std::vector<std::string> before = app.remaining();
  if (&command == &app && !before.empty() && !is_flag(before.front())) {
    return unknown_command(before.front(), app);
  }
  const std::vector<std::string> unknown = app.remaining(true);
  const auto flag = std::find_if(unknown.begin(), unknown.end(), is_flag);
  if (flag == unknown.end()) return error.what();
  if (has_flag(command, *flag)) return "the flag " + excerpt(*flag) + " goes behind its command";
  return unknown_flag(*flag, command);
}

}  // namespace

void require_double_dashes(const CLI::App& app, const std::vector<std::string>& arguments) {
  const CLI::App* command = nullptr;
  for (const std::string& word : arguments) {
    if (command == nullptr) {
      const auto found =
          app.get_subcommands([&](const auto* one) { return one->check_name(word); });
      if (!found.empty()) command = found.front();
    } else if (word.size() > 2 && word[0] == '-' && word[1] != '-' &&
               has_flag(*command, "-" + word)) {
      throw UsageError(unknown_flag(word, *command) + help_hint(app, *command));
    }
  }
}

std::string wrong_usage(const CLI::App& app, const CLI::ParseError& error) {
  return reason(app, error) + help_hint(app, given_command(app));
}

}  // namespace raywalk
