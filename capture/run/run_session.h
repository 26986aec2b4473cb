// `raywalk-capture run`: a whole session with real devices.
#pragma once

#include <filesystem>
#include <string>

#include "capture/config/capture_config.h"

namespace raywalk::capture {

struct RunOptions {
  std::filesystem::path session;  // directory, made or gone on with; not touched by a dry run
  bool dry_run = false;           // moves to every station and triggers nothing
  bool yes = false;               // nobody is asked to place the rail
};

// Homes, then captures what the session lacks; `config` was read from a file. Returns one line that
// says what is there now. Throws Paused, Interrupted, and Error or UsageError where it cannot
// begin; the slider then stands.
std::string run_session(const CaptureConfig& config, const RunOptions& options);

}  // namespace raywalk::capture
