// `raywalk-capture run`: a whole session with real devices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/config/capture_config.h"

namespace raywalk::capture {

struct RunOptions {
  std::filesystem::path session;     // directory, created or resumed; not touched by a dry run
  bool dry_run = false;              // moves to every station without taking pictures
  bool yes = false;                  // as for place_rail
  std::vector<std::string> lines{};  // as for select_lines; empty: all
};

// Homes the slider, then captures the stations that the session lacks; `config` was read from a
// file. Returns one line that sums up the session and names the next step. Throws Paused,
// Interrupted, and Error or UsageError if it cannot start; the slider is at rest in every case.
std::string run_session(const CaptureConfig& config, const RunOptions& options);

}  // namespace raywalk::capture
