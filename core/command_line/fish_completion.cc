// Completion for fish.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/command_line/completion_text.h"
#include "core/command_line/program_reference.h"

namespace raywalk {
namespace {

std::string fish_quoted(const std::string& text) {
  std::string shown = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') shown += '\\';
    shown += c;
  }
  return shown + "'";
}

// " -l out -s o -r -F": its names, whether it takes a value, and which.
std::string names_and_values(const OptionReference& option) {
  std::string text;
  for (const std::string& flag : option.flags) {
    const bool is_long = flag.starts_with("--");
    text += (is_long ? " -l " : " -s ") + flag.substr(is_long ? 2 : 1);
  }
  if (!option.value.empty() && !option.flags.empty()) text += option.takes_path ? " -r" : " -x";
  if (option.takes_path) text += " -F";
  if (!option.choices.empty()) {
    text += " -a " + fish_quoted(fmt::format("{}", fmt::join(option.choices, " ")));
  }
  return text;
}

std::string lines_of(const std::string& program, const std::string& condition,
                     const std::vector<OptionReference>& options) {
  std::string lines;
  for (const OptionReference& option : options) {
    lines +=
        fmt::format("complete -c {} -n {}{} -d {}\n", program, fish_quoted(condition),
                    names_and_values(option), fish_quoted(short_description(option.description)));
  }
  return lines;
}

}  // namespace

std::string fish_completion(const ProgramReference& program) {
  std::string script = fmt::format(
      "# Made by {0} --completion fish from the definitions of its commands.\ncomplete -c {0} -f\n",
      program.name);
  for (const CommandReference& command : program.commands) {
    script += fmt::format("complete -c {} -n __fish_use_subcommand -a {} -d {}\n", program.name,
                          command.name, fish_quoted(command.description));
  }
  script += lines_of(program.name, "__fish_use_subcommand", program.options);
  for (const CommandReference& command : program.commands) {
    script +=
        lines_of(program.name, "__fish_seen_subcommand_from " + command.name, command.options);
  }
  return script;
}

}  // namespace raywalk
