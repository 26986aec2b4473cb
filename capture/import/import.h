// Imports into a session what a camera kept to itself: pictures from its card, or a video.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

struct ImportResult {
  std::size_t imported = 0;       // stations whose pictures this call imported
  std::size_t already_there = 0;  // stations that had them before
  std::string summary{};          // one line for the user: counts, clocks, what was left out
};

// Matches the pictures to the stations (match_pictures.h), copies them into the session's frames/
// and records them with their checksums, station by station, so an interrupted import can be
// resumed. The source files are not changed. Nothing is overwritten.
//
// Throws, with nothing imported: Error for a picture that clearly is of another kind than the
// session's frames (frame_kind.h), or listing the mismatches if a station or picture has no
// counterpart; with `allow_missing`, the complete stations are imported instead. With
// `first_station` the pictures are assigned by name (assign_by_name). Throws, with the
// preceding stations imported: Error naming a file that is not a complete picture, does not have
// the session's size, or differs from the picture that its station already has; Interrupted.
ImportResult import_pictures(const std::filesystem::path& session_directory,
                             std::span<const std::filesystem::path> files_and_directories,
                             bool allow_missing, Clock* clock,
                             const std::string& first_station = "");

struct VideoImportOptions {
  std::string line{};          // the recorded line; empty: detect it
  bool allow_missing = false;  // import even if some stations have no frame
  std::string format = "jpg";  // of the frames: "jpg" or "png"
};

// Compares the clock of a video, shot while the slider moved slowly, with the journal, selects the
// nearest sharp frame for each station of the recorded lines (video_stations.h) and records it with
// the carriage's position at that time. Stations that have a picture are skipped, so an interrupted
// import can be resumed. Reads the video twice and does not change it.
//
// Throws, with nothing imported: UsageError for a line that is not there; Error if the session has
// no journal, the file is not a video or its aspect ratio or size differs from the session's
// frames, its clock offset is ambiguous or too uncertain for the spacing, or stations lack frames.
// Interrupted at any time.
ImportResult import_video(const std::filesystem::path& session_directory,
                          const std::filesystem::path& video, const VideoImportOptions& options,
                          Clock* clock);

}  // namespace raywalk::capture
