// The keys of a capture's configuration file.
#pragma once

#include "capture/config/capture_config.h"
#include "core/files/settings.h"

namespace raywalk::capture {

// Every key, bound to `config`, which must outlive the schema. Validation lines of a file are
// appended to those of `config`.
SettingsSchema capture_schema(CaptureConfig* config);

}  // namespace raywalk::capture
