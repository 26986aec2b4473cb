// Redirects a configuration to a simulated rig, to rehearse a session as planned.
#pragma once

#include <filesystem>

#include "capture/config/capture_config.h"

namespace raywalk::capture {

// Replaces the addresses of slider, camera and rail placement by those of the rig that runs in
// `directory` (raywalk-simulate rig). Throws UsageError: no rig runs there, its rig.json cannot
// be read, or the configured camera is not of kind osc.
void use_rig_addresses(CaptureConfig* config, const std::filesystem::path& directory);

}  // namespace raywalk::capture
