// The simulated rig as a process of its own.
#pragma once

#include <filesystem>

#include "capture/simulated/rig/rig_config.h"

namespace raywalk::capture {

// Runs a rig on the machine's clock until the user asks to stop (Ctrl-C, SIGTERM). When it is
// ready, `out`/rig.json appears and its path is printed:
//   {"slider": "<out>/slider", "modbus_port": 1502, "camera_url": "http://127.0.0.1:8080",
//    "pid": 4711}
// It goes away with the rig, as the port's link does; card and truth stay, and a later rig goes on
// with them. Throws Error where another rig works in the directory, and as Rig does.
void simulate_rig(const RigConfig& config, const std::filesystem::path& out);

}  // namespace raywalk::capture
