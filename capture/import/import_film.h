// Brings the frames of a film, shot while the slider moved slowly, into a session.
#pragma once

#include <filesystem>
#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

struct FilmImportOptions {
  std::string line{};          // that the film shows; empty: find out
  bool allow_missing = false;  // import the stations that have a frame
  std::string format = "jpg";  // of the frames: "jpg" or "png"
  int jpeg_quality = 95;       // 1 to 100
};

struct FilmImport {
  std::size_t imported = 0;
  std::size_t already_there = 0;
  std::string summary;  // one line for people: counts, the clock and how sure it is, blurred frames
};

// Finds the film's clock from the journal (film_clock.h), takes for each station of the filmed line
// or lines the nearest sharp frame (film_stations.h) and records it with the position that the
// carriage had then. Stations that have their picture are left as they are, so that an import that
// was cut short goes on. The film is only read, twice.
//
// Throws, with nothing imported: UsageError for options; Error where the session has no journal,
// the file is no film or of another shape or size than the session's frames, its clock cannot be
// told or is too uncertain for the spacing, or stations lack frames. Interrupted at any time.
FilmImport import_film(const std::filesystem::path& session_directory,
                       const std::filesystem::path& film, const FilmImportOptions& options,
                       Clock* clock);

}  // namespace raywalk::capture
