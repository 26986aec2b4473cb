// Imports pictures from a camera's card into a session.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

struct PictureImport {
  std::size_t imported = 0;       // stations whose pictures this call imported
  std::size_t already_there = 0;  // stations that had them before
  std::string summary;            // one line for the user: counts, clocks, what was left out
};

// Matches the pictures to the stations , copies them into the session's frames/
// and records them with their checksums, station by station, so an interrupted import can be
// resumed. The source files are not changed. Nothing is overwritten.
//
// Throws, with nothing imported: Error for a picture that clearly is of another kind than the
// session's frames (frame_kind.h), or listing the mismatches if a station or picture has no
// counterpart; with `allow_missing`, the complete stations are imported instead. With
// `first_station` the pictures are assigned by name (assign_by_name). Throws, with the
// preceding stations imported: Error naming a file that is not a complete picture, does not have
// the session's size, or differs from the picture that its station already has; Interrupted.
PictureImport import_pictures(const std::filesystem::path& session_directory,
                              std::span<const std::filesystem::path> files_and_directories,
                              bool allow_missing, Clock* clock,
                              const std::string& first_station = "");

}  // namespace raywalk::capture
