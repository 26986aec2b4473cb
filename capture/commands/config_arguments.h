// The configuration that commands with devices take.
#pragma once

#include <string>

#include "capture/config/capture_config.h"

namespace CLI {
class App;
}

namespace raywalk::capture {

struct ConfigArguments {
  std::string config{};
  std::string rig{};  // directory of a simulated rig; empty: the configured devices
};

// Adds both to a command; `arguments` has to outlive it.
void add_config(CLI::App* command, ConfigArguments* arguments);

// Throws UsageError as read_capture_config and use_rig_addresses do.
CaptureConfig config_of(const ConfigArguments& arguments);

}  // namespace raywalk::capture
