// The keys of a capture's configuration file.
#pragma once

#include "capture/config/capture_config.h"
#include "core/files/settings.h"

namespace raywalk::capture {

// Every key, bound to `config`, which has to outlive the schema. A file's validation lines are
// added to those that `config` holds.
SettingsSchema capture_schema(CaptureConfig* config);

}  // namespace raywalk::capture
