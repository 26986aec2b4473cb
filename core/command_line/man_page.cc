// Manual pages, in the macros of man(7).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <sstream>
#include <string_view>

#include "core/command_line/program_reference.h"

namespace raywalk {
namespace {

constexpr const char* kPrograms[] = {"raywalk-build-lf", "raywalk-calibrate", "raywalk-capture",
                                     "raywalk-render"};
// Of the source, with escapes.
constexpr std::size_t kLineLength = 78;

constexpr std::string_view kExitStatus =
    ".SH EXIT STATUS\n"
    ".TP\n\\fB0\\fR\nDone.\n"
    ".TP\n\\fB1\\fR\nFailed; one line on standard error tells why.\n"
    ".TP\n\\fB2\\fR\nWrong usage or configuration.\n"
    ".TP\n\\fB3\\fR\nPaused; the same command resumes.\n"
    ".TP\n\\fB130\\fR\nInterrupted.\n";

constexpr std::string_view kFiles =
    ".SH FILES\n"
    "Raywalk's own configuration files are in\n"
    ".I share/raywalk/configs\n"
    "beside the folder of the program.\n"
    "Where a file of settings or a lens file is asked for, one of them can be named\n"
    "without folder and extension.\n";

// Dashes as they are typed; a list that is longer than a line may be broken behind a comma.
std::string escaped_for_roff(std::string_view text) {
  constexpr std::size_t kLong = 40;
  std::string shown;
  for (const char c : text) {
    if (c == '\\') {
      shown += "\\e";
    } else if (c == '-') {
      shown += "\\-";
    } else if (c == ',' && text.size() > kLong) {
      shown += ",\\:";
    } else {
      shown += c;
    }
  }
  return shown;
}

// The same at the beginning of a line, where no character may make it a request.
std::string roff(std::string_view text) {
  const std::string shown = escaped_for_roff(text);
  return shown.starts_with('.') || shown.starts_with('\'') ? "\\&" + shown : shown;
}

// The words in lines of at most kLineLength.
std::string filled(const std::string& text) {
  std::istringstream words(text);
  std::string lines, line;
  for (std::string word; words >> word;) {
    const std::string longer = line.empty() ? roff(word) : line + ' ' + escaped_for_roff(word);
    if (longer.size() <= kLineLength || line.empty()) {
      line = longer;
      continue;
    }
    lines += line + '\n';
    line = roff(word);
  }
  return line.empty() ? lines : lines + line + '\n';
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string bold(std::string_view text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + roff(text) + "\\fR"; }

std::string sentence(const std::string& text) {
  const bool ends = text.empty() || text.ends_with('.') || text.ends_with('?');
  return ends ? text : text + '.';
}

std::string values_text(const OptionReference& option) {
  std::string text;
  if (!option.choices.empty() && !option.takes_path) {
    text += fmt::format(" Valid: {}.", fmt::join(option.choices, ", "));
  }
  if (!option.limits.empty()) text += fmt::format(" Range: {}.", option.limits);
  if (!option.default_value.empty()) text += fmt::format(" Default: {}.", option.default_value);
  if (option.is_list) text += " Several are separated by commas.";
  if (option.required && !option.flags.empty()) text += " Required.";
  return text;
}

std::string entry(const OptionReference& option) {
  std::string head;
  for (const std::string& flag : option.flags) head += (head.empty() ? "" : ", ") + bold(flag);
  if (!option.value.empty()) head += (head.empty() ? "" : " ") + italic(option.value);
  if (option.repeats && !option.is_list) head += " ...";
  return ".TP\n" + head + "\n" + filled(sentence(option.description) + values_text(option));
}

// "raywalk-render view [OPTION]... room --at X,Z", what is required last.
std::string synopsis(const ProgramReference& program, const CommandReference& command) {
  std::string line = bold(program.name + " " + command.name) + " [" + italic("OPTION") + "]...";
  for (const OptionReference& option : command.options) {
    if (!option.flags.empty()) continue;
    const std::string name = italic(option.value) + (option.repeats ? "..." : "");
    line += option.required ? " " + name : " [" + name + "]";
  }
  for (const OptionReference& option : command.options) {
    if (!option.flags.empty() && option.required) {
      line += " " + bold(option.flags.back()) + " " + italic(option.value);
    }
  }
  return line + "\n";
}

// Commands are indented in a footer; all else is text.
std::string footer_text(const std::string& footer) {
  std::istringstream lines(footer);
  std::string page, text;
  bool in_example = false;
  const auto end_text = [&] {
    if (!text.empty()) page += ".PP\n" + filled(text);
    text.clear();
  };
  for (std::string line; std::getline(lines, line);) {
    const bool is_example = line.starts_with("  ");
    if (is_example && !in_example) {
      end_text();
      page += ".PP\n.RS 4\n.nf\n";
    }
    if (!is_example && in_example) page += ".fi\n.RE\n";
    in_example = is_example;
    if (is_example) {
      page += roff(line.substr(2)) + "\n";
    } else {
      text += line + " ";
    }
  }
  if (in_example) page += ".fi\n.RE\n";
  end_text();
  return page;
}

bool is_option_of(const ProgramReference& program, const OptionReference& option) {
  return !option.flags.empty() &&
         std::any_of(program.options.begin(), program.options.end(),
                     [&](const OptionReference& other) { return other.flags == option.flags; });
}

// The options of a group under its name, the first groups first; those of every command are
// described once, for the program.
std::string command_section(const ProgramReference& program, const CommandReference& command) {
  std::string page = ".SS " + roff(program.name + " " + command.name) + "\n" +
                     filled(sentence(command.description)) + ".PP\n" + synopsis(program, command);
  for (const OptionReference& argument : arguments_among(command.options)) page += entry(argument);
  std::vector<std::string> groups;
  for (const OptionReference& option : command.options) {
    if (!option.flags.empty() &&
        std::find(groups.begin(), groups.end(), option.group) == groups.end()) {
      groups.push_back(option.group);
    }
  }
  for (const std::string& group : groups) {
    std::string entries;
    for (const OptionReference& option : command.options) {
      if (option.group == group && !option.flags.empty() && !is_option_of(program, option)) {
        entries += entry(option);
      }
    }
    if (!entries.empty()) page += fmt::format(".PP\n{}:\n{}", roff(group), entries);
  }
  return page + footer_text(command.footer);
}

std::string see_also(const ProgramReference& program) {
  std::string page = ".SH SEE ALSO\n", between;
  for (const char* other : kPrograms) {
    if (other == program.name) continue;
    page += between + ".BR " + roff(other) + " (1)";
    between = ",\n";
  }
  return page + "\n";
}

}  // namespace

std::string man_page(const ProgramReference& program, const std::string& date) {
  const std::string version = program.version.substr(program.version.rfind(' ') + 1);
  std::string page = fmt::format(
      ".\\\" Made by {} \\-\\-man from the definitions of its commands.\n"
      ".TH {} 1 {} \"Raywalk {}\" \"Raywalk\"\n.nh\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n"
      "{} {} [{}]...\n.SH DESCRIPTION\n{}.SH OPTIONS\n",
      roff(program.name), roff(upper(program.name)), date, version, roff(program.name),
      roff(program.description), bold(program.name), italic("COMMAND"), italic("ARGUMENT"),
      filled(sentence(program.description)));
  for (const OptionReference& option : program.options) page += entry(option);
  page += footer_text(program.footer) + ".SH COMMANDS\n";
  for (const CommandReference& command : program.commands) {
    page += command_section(program, command);
  }
  return page + std::string(kExitStatus) + std::string(kFiles) + see_also(program);
}

}  // namespace raywalk
