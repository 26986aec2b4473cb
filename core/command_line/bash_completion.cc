// Completion for bash.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/command_line/program_reference.h"

namespace raywalk {
namespace {

// The word being completed, the flag before it, and the command. bash makes three words of
// --flag=value.
constexpr const char* kHead =
    R"(  local cur=${{COMP_WORDS[COMP_CWORD]}} flag=${{COMP_WORDS[COMP_CWORD-1]}}
  if [[ $cur == '=' ]]; then
    cur=''
  elif [[ $flag == '=' ]]; then
    flag=${{COMP_WORDS[COMP_CWORD-2]}}
  fi
  local command='' word
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case $word in
      {}) command=$word; break ;;
    esac
  done
  # What can stand here: flags, words, paths; several words with commas between them.
  local flags='' words='' paths='' list=''
)";

constexpr const char* kTail = R"(  COMPREPLY=()
  if [[ -n $list ]]; then
    mapfile -t COMPREPLY < <(compgen -P "${cur%"${cur##*,}"}" -W "$words" -- "${cur##*,}")
    return
  fi
  if [[ -n $flags && ( $cur == -* || -z $words$paths ) ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$flags" -- "$cur")
    return
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur"; [[ -z $paths ]] || compgen -f -- "$cur")
  # Fails where no key called this function.
  [[ -z $paths ]] || compopt -o filenames 2>/dev/null
  return 0
)";

std::string assigned(const std::vector<std::string>& words, bool paths) {
  std::string text = words.empty() ? "" : fmt::format("words='{}'", fmt::join(words, " "));
  if (paths) text += text.empty() ? "paths=1" : " paths=1";
  return text;
}

// "        --out|-o) paths=1 ;;"
std::string value_case(const OptionReference& option) {
  std::string text = assigned(option.choices, option.takes_path);
  if (option.is_list && !option.choices.empty()) text += " list=1";
  return fmt::format("        {}) {} ;;\n", fmt::join(option.flags, "|"),
                     text.empty() ? "COMPREPLY=(); return" : text);
}

std::vector<std::string> all_flags(const std::vector<OptionReference>& options) {
  std::vector<std::string> flags;
  for (const OptionReference& option : options) {
    flags.insert(flags.end(), option.flags.begin(), option.flags.end());
  }
  return flags;
}

// Values of flags, and where no flag asks for one, flags and arguments.
std::string command_case(const CommandReference& command) {
  std::string text = fmt::format("    {})\n      case $flag in\n", command.name);
  for (const OptionReference& option : command.options) {
    if (!option.flags.empty() && !option.value.empty()) text += value_case(option);
  }
  std::vector<std::string> words;
  bool paths = false;
  for (const OptionReference& argument : arguments_among(command.options)) {
    words.insert(words.end(), argument.choices.begin(), argument.choices.end());
    paths = paths || argument.takes_path;
  }
  return text + fmt::format("        *) flags='{}' {} ;;\n      esac ;;\n",
                            fmt::join(all_flags(command.options), " "), assigned(words, paths));
}

}  // namespace

std::string bash_completion(const ProgramReference& program) {
  std::vector<std::string> commands;
  for (const CommandReference& command : program.commands) commands.push_back(command.name);
  std::string function = "_" + program.name;
  std::replace(function.begin(), function.end(), '-', '_');
  std::string script =
      fmt::format("# Made by {} --completion bash from the definitions of its commands.\n{}() {{\n",
                  program.name, function);
  script += fmt::format(kHead, fmt::join(commands, "|"));
  script += fmt::format("  case $command in\n    '') flags='{}' words='{}' ;;\n",
                        fmt::join(all_flags(program.options), " "), fmt::join(commands, " "));
  for (const CommandReference& command : program.commands) script += command_case(command);
  return script + "  esac\n" + kTail +
         fmt::format("}}\ncomplete -F {} {}\n", function, program.name);
}

}  // namespace raywalk
