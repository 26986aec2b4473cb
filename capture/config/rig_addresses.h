// A configuration turned to the simulated rig, so that a session can be rehearsed as it is planned.
#pragma once

#include <filesystem>

#include "capture/config/capture_config.h"

namespace raywalk::capture {

// Replaces the addresses of slider and camera, and who places the rail, by those of the rig that
// works in `directory` (raywalk-capture simulate). Throws UsageError: no rig works there, its
// rig.json cannot be read, or the configured camera is not one that is reached over HTTP.
void use_rig_addresses(CaptureConfig* config, const std::filesystem::path& directory);

}  // namespace raywalk::capture
