// What is wrong with a command line: CLI11's own words, or the unknown flag or command with the
// nearest valid one.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace raywalk {

// Throws UsageError for a flag of several letters behind a single dash ("-out"): it would be read
// as "-o ut". `arguments` are those behind the program's name.
void require_double_dashes(const CLI::App& app, const std::vector<std::string>& arguments);

// The message for a command line that CLI11 refused. It ends with the --help that applies, "see
// raywalk-render view --help". `app` is as the failed parse left it.
std::string wrong_usage(const CLI::App& app, const CLI::ParseError& error);

}  // namespace raywalk
