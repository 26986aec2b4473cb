#include "capture/commands/config_arguments.h"

#include <CLI/CLI.hpp>

#include "core/command_line/command_options.h"
#include "core/files/shipped_configs.h"

namespace raywalk::capture {

void add_capture_config(CLI::App* command, std::string* config) {
  takes_config(
      command->add_option("config", *config,
                          "Settings: a file, or the name of one in configs, as capture-osc"),
      ConfigKind::kCapture)
      ->required();
}

void add_config(CLI::App* command, ConfigArguments* arguments) {
  add_capture_config(command, &arguments->config);
  command->add_option("--rig", arguments->rig,
                      "Use the simulated rig that runs in this directory instead of the configured "
                      "devices");
}

std::filesystem::path capture_config_file(const std::string& config) {
  return named_config(config, ConfigKind::kCapture, "config");
}

void add_lines(CLI::App* command, std::vector<std::string>* lines) {
  command
      ->add_option(
          "--lines", *lines,
          "Only these lines of the plan, as a session of their own: x0,x3-x5 (default: all)")
      ->type_name("LINES")
      ->delimiter(',');
}

CaptureConfig config_of(const ConfigArguments& arguments) {
  CaptureConfig config = read_capture_config(capture_config_file(arguments.config));
  if (!arguments.rig.empty()) use_rig_addresses(&config, arguments.rig);
  return config;
}

}  // namespace raywalk::capture
