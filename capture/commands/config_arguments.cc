#include "capture/commands/config_arguments.h"

#include <CLI/CLI.hpp>

#include "capture/config/rig_addresses.h"

namespace raywalk::capture {

void add_config(CLI::App* command, ConfigArguments* arguments) {
  command->add_option("config", arguments->config, "Settings, as in configs/capture-osc.yaml")
      ->required();
  command->add_option("--rig", arguments->rig,
                      "Use the simulated rig that runs in this directory instead of the configured "
                      "devices");
}

CaptureConfig config_of(const ConfigArguments& arguments) {
  CaptureConfig config = read_capture_config(arguments.config);
  if (!arguments.rig.empty()) use_rig_addresses(&config, arguments.rig);
  return config;
}

}  // namespace raywalk::capture
