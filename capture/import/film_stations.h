// Selects the frame of a film for each station.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "capture/import/film_clock.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

struct StationFrame {
  std::size_t station = 0;   // index into SessionContents::stations
  std::size_t frame = 0;     // index into FilmTrack::frames
  double time_s = 0.0;       // of the journal
  double position_mm = 0.0;  // of the frame, on the rail
};

struct FilmStations {
  std::vector<StationFrame> found;        // in order of frames
  std::vector<std::size_t> missing;       // stations of the filmed lines without any frame
  std::vector<std::size_t> only_blurred;  // stations with blurred frames only
  std::size_t blurred_skipped = 0;        // stations whose nearest frame was blurred
};

// For each station of the filmed lines, the sharp frame with the least position error: the minimum
// of |position - planned| + speed * clock uncertainty. Frames farther than half the distance to the
// next station do not count.
FilmStations find_station_frames(const SessionContents& contents, const FilmTrack& track,
                                 std::span<const Travel> travels, const FilmClock& clock);

}  // namespace raywalk::capture
