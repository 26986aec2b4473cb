// Brings pictures from a camera's card into a session.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

struct PictureImport {
  std::size_t imported = 0;       // stations that have their pictures now
  std::size_t already_there = 0;  // stations that had them before
  std::string summary;            // one line for people: counts, clocks, what was left out
};

// Matches the pictures to the stations (match_pictures.h), copies them into the session's frames/
// and records them with their checksums, station by station: an import that was cut short goes on
// when it is run again. The files given are only read. Nothing is overwritten.
//
// Throws, with nothing imported: Error with the account of what lacks what, where not every station
// and picture has found its counterpart; `allow_missing` imports what has. Throws, with the
// stations before it imported: Error naming a file that is no whole picture, or not of the
// session's size; one that differs from what the session already holds for its station;
// Interrupted.
PictureImport import_pictures(const std::filesystem::path& session_directory,
                              std::span<const std::filesystem::path> files_and_directories,
                              bool allow_missing, Clock* clock);

}  // namespace raywalk::capture
