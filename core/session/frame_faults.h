// Whether the frames that a session names are on the disk.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/session/session_contents.h"

namespace raywalk {

// Something wrong with the frames of a captured station.
struct FrameFault {
  std::string station{};  // its name
  std::string text{};     // "frames/x0_007.jpg (station x0_007): No such file or directory"
};

// What is wrong with the file of a frame by its type and size; empty where nothing is. Does not
// read it.
std::string file_fault(const SessionContents& contents, const SessionFrame& frame);

// The captured stations that lack an exposure or the picture of a lens, in their order.
std::vector<FrameFault> incomplete_stations(const SessionContents& contents);

// These, and the frames whose file is missing or of another size. Does not read the files.
std::vector<FrameFault> frame_faults(const SessionContents& contents);

// Throws Error, naming the session, the first fault and what to do, if there are faults.
void require_no_faults(const std::vector<FrameFault>& faults,
                       const std::filesystem::path& directory);

}  // namespace raywalk
