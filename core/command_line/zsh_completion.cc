// Completion for zsh, by its _arguments.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/command_line/completion_text.h"
#include "core/command_line/program_reference.h"

namespace raywalk {
namespace {

// In a description [between brackets] of a specification in single quotes.
std::string zsh_quoted(const std::string& text) {
  std::string shown;
  for (const char c : text) {
    if (c == '\'') {
      shown += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') shown += '\\';
      shown += c;
    }
  }
  return shown;
}

// ":room:_files", what completes a value.
std::string action(const OptionReference& option) {
  const std::string name = zsh_quoted(option.value);
  const std::string words = fmt::format("{}", fmt::join(option.choices, " "));
  if (option.takes_path) {
    return option.choices.empty() ? fmt::format(":{}:_files", name)
                                  : fmt::format(":{}:{{compadd -- {}; _files}}", name, words);
  }
  if (option.choices.empty()) return fmt::format(":{}: ", name);
  return option.is_list ? fmt::format(":{}:_values -s , value {}", name, words)
                        : fmt::format(":{}:({})", name, words);
}

// "'(-o --out)'{-o+,--out=}'[What it is]:TEXT:_files'"
std::string flag_specification(const OptionReference& option) {
  const bool has_value = !option.value.empty();
  const std::string rest = fmt::format("[{}]{}'", zsh_quoted(short_description(option.description)),
                                       has_value ? action(option) : "");
  std::vector<std::string> forms;
  for (const std::string& flag : option.flags) {
    const bool is_long = flag.starts_with("--");
    forms.push_back(flag + (!has_value ? "" : is_long ? "=" : "+"));
  }
  if (option.repeats) return fmt::format("'*{}{}", forms.back(), rest);
  if (forms.size() == 1) return fmt::format("'{}{}", forms.front(), rest);
  return fmt::format("'({})'{{{}}}'{}", fmt::join(option.flags, " "), fmt::join(forms, ","), rest);
}

std::string specifications(const std::vector<OptionReference>& options, const char* indent) {
  std::string text;
  for (const OptionReference& option : options) {
    text += fmt::format(" \\\n{}{}", indent,
                        option.flags.empty()
                            ? fmt::format("'{}{}'", option.repeats ? "*" : "", action(option))
                            : flag_specification(option));
  }
  return text + "\n";
}

}  // namespace

std::string zsh_completion(const ProgramReference& program) {
  std::string script = fmt::format(
      "#compdef {0}\n# Made by {0} --completion zsh from the definitions of its commands.\n"
      "local curcontext=$curcontext state line\nlocal -A opt_args\nlocal -a commands\ncommands=(\n",
      program.name);
  for (const CommandReference& command : program.commands) {
    script += fmt::format("  '{}:{}'\n", command.name, zsh_quoted(command.description));
  }
  script += ")\n_arguments -C ':command:->command' '*::argument:->argument'" +
            specifications(program.options, "  ") +
            "case $state in\n  command) _describe command commands ;;\n  argument)\n"
            "    curcontext=${curcontext%:*}-$words[1]:\n    case $words[1] in\n";
  for (const CommandReference& command : program.commands) {
    script += fmt::format("      {}) _arguments{}        ;;\n", command.name,
                          specifications(command.options, "        "));
  }
  return script + "    esac ;;\nesac\n";
}

}  // namespace raywalk
