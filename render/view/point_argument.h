// A point of the plan or of space on a command line, written as people write it: --at 0,0, or
// --at 0 0, or --at "0, 0".
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace raywalk::render {

// Two or three finite numbers with a comma, spaces or both between them, in the order they were
// written; none for anything else.
std::vector<double> parse_point(std::string_view text);

// Which numbers a point has.
enum class PointKind { kPlan, kPlanOrSpace };  // X,Z, or also X,Y,Z

// Adds an option whose value `text` is written as above, as one word or as several.
CLI::Option* add_point_option(CLI::App* command, const std::string& flag, std::string* text,
                              const std::string& description, PointKind kind = PointKind::kPlan);

// The arguments of a command line (without the program's name), with the words that make up the
// value of a point option joined to one. Words that cannot be part of it stay as they are.
std::vector<std::string> joined_points(const CLI::App& app,
                                       const std::vector<std::string>& arguments);

}  // namespace raywalk::render
