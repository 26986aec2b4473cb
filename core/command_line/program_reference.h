// What a program's command line consists of, read from its definition: what the manual page and the
// completion of shells are made from, so that they cannot differ from what the program takes.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace raywalk {

struct OptionReference {
  std::vector<std::string> flags{};  // "-o", "--out"; empty: a positional argument
  std::string value{};               // what stands for its value, as in the help; empty: takes none
  std::vector<std::string> choices{};  // words that it takes
  bool takes_path = false;             // a file or directory, beside the choices
  bool is_list = false;                // values with commas between them
  bool repeats = false;                // any number of values
  bool required = false;
  std::string group{};
  std::string description{};
  std::string limits{};         // "0 - 1024"
  std::string default_value{};  // empty: none, or told by the description
};

struct CommandReference {
  std::string name{};
  std::string description{};
  std::vector<OptionReference> options{};
  std::string footer{};
};

struct ProgramReference {
  std::string name{};
  std::string version{};  // "raywalk-render 0.1.0"
  std::string description{};
  std::vector<OptionReference> options{};
  std::vector<CommandReference> commands{};
  std::string footer{};
};

// Of what the help shows: hidden options are left out.
ProgramReference reference_of(const CLI::App& app);

// The positional arguments among `options`, in their order.
std::vector<OptionReference> arguments_among(const std::vector<OptionReference>& options);

// The manual page, in the macros of man(7): the program, then every command as a subsection. `date`
// is that of the page, "2026-11-25".
std::string man_page(const ProgramReference& program, const std::string& date);

// A script that completes commands, flags, their fixed values, names of configuration files and
// paths. That of bash defines the function _raywalk_render (of raywalk-render).
std::string bash_completion(const ProgramReference& program);

}  // namespace raywalk
