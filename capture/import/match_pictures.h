// Assigns the pictures of a camera's card to the stations of a session.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "capture/import/card_pictures.h"
#include "capture/session/session.h"

namespace raywalk::capture {

// A station whose pictures are on the card.
struct ExposedStation {
  AttemptId attempt{};  // the attempt that took them
  WallTime from{};      // its pictures were taken in [from, to] of the session's clock
  WallTime to{};
  bool imported = false;  // by an earlier import
};

// An attempt that failed or was interrupted and may have left pictures on the card.
struct FailedAttempt {
  WallTime from{};
  WallTime to{};
};

struct SessionShots {
  std::vector<ExposedStation> stations{};  // in order of time
  std::vector<FailedAttempt> failed{};
  int exposures = 1;  // pictures per station
};

// The camera's clock against the session's.
struct CameraClock {
  double offset_s = 0.0;  // camera minus session, at the first station
  double drift = 0.0;     // growth of the offset per second; under 1e-4 for a good quartz clock
  double rms_s = 0.0;     // of the residuals
};

struct StationPictures {
  std::size_t station = 0;         // index into SessionShots::stations
  std::vector<std::size_t> shots;  // indices into CardPictures::shots, one per exposure
};

struct PictureMatch {
  std::vector<StationPictures> complete{};  // stations of which all exposures are on the card
  std::size_t from_failed = 0;              // pictures of failed attempts
  std::optional<CameraClock> clock{};       // none if assigned by name
  // One line for the user: stations with missing pictures, unless imported before, and pictures
  // without a station. Empty if there are none.
  std::string mismatches{};
};

// Matches by order and by the time between the pictures. The camera's clock may have any offset and
// a drift of up to 1e-4; pictures may be missing or of no station. Throws Error if the times fit
// several assignments, as those of an evenly timed line do whose first or last picture is missing;
// or if more than a tenth both of the pictures and of the stations do not match, as with pictures
// of another session, or of a camera whose clock was set meanwhile.
PictureMatch match_pictures(const SessionShots& session, const CardPictures& card);

// Assigns all pictures, in order of their names and whatever their times, to the stations from
// `first_station` on in the order of capture. Throws Error if no picture of that station is on the
// card, a bracket is not complete, or the stations are fewer.
PictureMatch assign_by_name(const SessionShots& session, const CardPictures& card,
                            const std::string& first_station);

}  // namespace raywalk::capture
