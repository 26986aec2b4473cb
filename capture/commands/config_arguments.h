// The configuration arguments shared by the commands that use devices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/config/capture_config.h"

namespace CLI {
class App;
}

namespace raywalk::capture {

struct ConfigArguments {
  std::string config{};
  std::string rig{};  // directory of a simulated rig; empty: the configured devices
};

// The settings of a capture, a positional argument: a path, or the name of one of Raywalk's own.
void add_capture_config(CLI::App* command, std::string* config);

// The file that the argument means. Throws UsageError where there is none.
std::filesystem::path capture_config_file(const std::string& config);

// Adds the arguments to a command; `arguments` must outlive it.
void add_config(CLI::App* command, ConfigArguments* arguments);

// Adds --lines, the words of select_lines (line_selection.h); `lines` must outlive the command.
void add_lines(CLI::App* command, std::vector<std::string>* lines);

// Throws UsageError as read_capture_config and use_rig_addresses do.
CaptureConfig config_of(const ConfigArguments& arguments);

}  // namespace raywalk::capture
