// Imports frames of a film, shot while the slider moved slowly, into a session.
#pragma once

#include <filesystem>
#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

struct FilmImportOptions {
  std::string line{};          // the filmed line; empty: detect it
  bool allow_missing = false;  // import even if some stations have no frame
  std::string format = "jpg";  // of the frames: "jpg" or "png"
};

struct FilmImport {
  std::size_t imported = 0;
  std::size_t already_there = 0;
  std::string
      summary{};  // one line for the user: counts, clock offset, uncertainty, blurred frames
};

// Compares the film's clock with the journal, selects the nearest sharp frame for each station of
// the filmed lines (film_stations.h) and records it with the carriage's position at that time.
// Stations that have a picture are skipped, so an interrupted import can be resumed. Reads the film
// twice and does not change it.
//
// Throws, with nothing imported: UsageError for a line that is not there; Error if the session has
// no journal, the file is not a film or its aspect ratio or size differs from the session's frames,
// its clock offset is ambiguous or too uncertain for the spacing, or stations lack frames.
// Interrupted at any time.
FilmImport import_film(const std::filesystem::path& session_directory,
                       const std::filesystem::path& film, const FilmImportOptions& options,
                       Clock* clock);

}  // namespace raywalk::capture
