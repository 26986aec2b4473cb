// By how much the time of a film is off from the journal's.
#pragma once

#include <span>
#include <string>

#include "capture/import/film_track.h"
#include "capture/import/travel.h"

namespace raywalk::capture {

struct FilmClock {
  double offset_s = 0.0;       // journal time minus film time
  double uncertainty_s = 0.0;  // half the width of its 95 % interval
  double explained = 0.0;      // share of the picture's changes that the motion explains, 0 to 1
  double next_best = 0.0;      // the same at the best offset elsewhere
};

// Finds the offset at which the carriage's motion explains the film's activity best. Starts and
// stops tell it: a film of nothing but steady motion is refused. `film` names the film in errors.
//
// With a_k the activity of frame k and m_k(offset) the carriage's speed between frames k - 1 and k,
// both cut to [0, 1] between rest and steady motion (how strongly a scene shows the same motion
// varies along the way), the fit a = p + q m, q > 0, over the frames within the journal leaves the
// least when
//   G(offset) = S_am^2 / (S_mm (S_aa + R))
// is greatest. S are centred sums over these frames. R is the sum of a^2 over the frames outside of
// the journal that show motion, where the camera should rest: without it an offset at which film
// and journal hardly overlap would have little to explain and explain it well. As m_k is a mean
// over the time between two frames, G changes within a frame interval, and its maximum is found to
// a part of one.
//
// Throws Error: no motion to be seen, no offset explains half of the activity, or two do nearly
// equally well.
FilmClock match_film_clock(const FilmTrack& track, std::span<const Travel> travels,
                           const std::string& film);

}  // namespace raywalk::capture
