// Runs the simulated rig as a process.
#pragma once

#include <filesystem>

#include "simulator/rig/rig_config.h"

namespace raywalk::capture {

// Runs a rig on the system clock until Ctrl-C or SIGTERM. When it is ready, `out`/rig.json appears
// and its path is printed:
//   {"slider": "<out>/slider", "modbus_port": 1502, "camera_url": "http://127.0.0.1:8080",
//    "pid": 4711}
// rig.json and the link of the serial port are removed at the end; card and truth are kept, and a
// later rig appends to them. Throws Error if another rig uses the directory, and as Rig does.
void simulate_rig(const RigConfig& config, const std::filesystem::path& out);

}  // namespace raywalk::capture
