#include "render/commands/report_option.h"

#include <CLI/CLI.hpp>

#include "core/files/output_folder.h"

namespace raywalk::render {

CLI::Option* add_report(CLI::App* command, std::filesystem::path* report,
                        const std::string& description) {
  return command->add_option("-o,--report,--out", *report, description);
}

void add_match_exposure(CLI::App* command, bool* match) {
  command->add_flag("--match-exposure", *match,
                    "Give every view the exposure of its truth before it is compared, one factor "
                    "per colour: for truths of a camera that exposes by itself");
}

std::filesystem::path report_of(const std::filesystem::path& given, const std::string& room,
                                const std::string& command) {
  if (!given.empty()) return given;
  return without_trailing_slash(room).stem().string() + "-" + command;
}

}  // namespace raywalk::render
