// What commands share that compare views with truths: the folder of the report, the exposure.
#pragma once

#include <filesystem>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace raywalk::render {

// Adds --report, which is also named -o and --out as the result of other commands is. `report` has
// to outlive the command.
CLI::Option* add_report(CLI::App* command, std::filesystem::path* report,
                        const std::string& description);

// Adds --match-exposure (exposed_as of core/evaluate/truth_views.h).
void add_match_exposure(CLI::App* command, bool* match);

// `given`, or where it is empty a folder named after the room: hall.lf becomes hall-validate.
std::filesystem::path report_of(const std::filesystem::path& given, const std::string& room,
                                const std::string& command);

}  // namespace raywalk::render
