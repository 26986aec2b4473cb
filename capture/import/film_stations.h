// Which frame of a film shows which station.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "capture/import/film_clock.h"
#include "capture/session/session_reader.h"

namespace raywalk::capture {

struct StationFrame {
  std::size_t station = 0;   // index into the stations given
  std::size_t frame = 0;     // index into FilmTrack::frames
  double time_s = 0.0;       // of the journal
  double position_mm = 0.0;  // of the frame, on the rail
};

struct FilmStations {
  std::vector<StationFrame> found;        // in order of frames
  std::vector<std::size_t> without;       // stations of the filmed lines that no frame shows
  std::vector<std::size_t> only_blurred;  // stations that only blurred frames show
  std::size_t blurred_passed = 0;         // stations whose nearest frame was blurred
};

// For each station of the lines that the film shows, the sharp frame whose position is nearest and
// best known: the least |position - planned| + speed * uncertainty of the clock. A frame serves a
// station only within half the way to the next one. Stations in the order of the plan.
FilmStations find_station_frames(std::span<const StationRecord> stations, const FilmTrack& track,
                                 std::span<const Travel> travels, const FilmClock& clock);

}  // namespace raywalk::capture
