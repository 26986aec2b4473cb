// The offset between the clock of a film and that of the session's journal.
#pragma once

#include <span>
#include <string>

#include "capture/import/film_track.h"
#include "capture/import/travel.h"

namespace raywalk::capture {

struct FilmClock {
  double offset_s = 0.0;       // journal time minus film time
  double uncertainty_s = 0.0;  // half the width of its 95 % interval
  double explained = 0.0;      // G at the offset (see below), 0 to 1
  double next_best = 0.0;      // G at the second-best maximum
};

// Finds the offset at which the carriage's motion best explains the film's activity. Only starts
// and stops determine it: a film of steady motion alone is rejected. `film` names the film in
// errors.
//
// Let a_k be the activity of frame k and m_k(offset) the carriage's speed between frames k - 1 and
// k. Both are clamped to [0, 1] between rest and steady motion, as the activity that a given speed
// causes varies along the line. The residual of the fit a = p + q m, q > 0, over the frames within
// the journal is least where
//   G(offset) = S_am^2 / (S_mm (S_aa + R))
// is greatest. S are centred sums over these frames. R is the sum of a^2 over frames with motion
// outside the journal, where the camera should be at rest; it penalizes offsets at which film and
// journal hardly overlap. As m_k is a mean over the time between two frames, G varies within a
// frame interval and its maximum is found with sub-frame precision.
//
// Throws Error if the film shows no motion, no offset explains half of the activity, or two offsets
// do so nearly equally well.
FilmClock match_film_clock(const FilmTrack& track, std::span<const Travel> travels,
                           const std::string& film);

}  // namespace raywalk::capture
