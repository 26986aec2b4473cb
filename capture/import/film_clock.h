// The offset between the clock of a film and that of the session's journal.
#pragma once

#include <span>
#include <string>

#include "capture/import/film_track.h"
#include "capture/import/travel.h"

namespace raywalk::capture {

struct FilmClock {
  double offset_s = 0.0;       // journal time minus film time
  double uncertainty_s = 0.0;  // half of what starts and stops disagree by, and half a frame
};

// Finds the offset at which the starts and stops that a film shows are successive ones of the
// carriage: the mean of those by the first and the last. A film of steady motion alone is rejected.
// `film` names the film in errors.
//
// A start is where the activity of frames, or the speed in the journal, passes a quarter of that in
// steady motion for good; both are averaged over the same time, so that the delay cancels.
//
// Throws Error if the film shows no motion, or its starts and stops fit the journal at no time or
// at several.
FilmClock match_film_clock(const FilmTrack& track, std::span<const Travel> travels,
                           const std::string& film);

}  // namespace raywalk::capture
