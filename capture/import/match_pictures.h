// Assigns the pictures of a camera's card to the stations of a session.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "capture/import/card_pictures.h"

namespace raywalk::capture {

// A station whose pictures are on the card.
struct ExposedStation {
  AttemptId attempt;  // the attempt that took them
  WallTime from{};    // its pictures were taken in [from, to] of the session's clock
  WallTime to{};
  bool imported = false;  // by an earlier import
};

// An attempt that failed or was interrupted and may have left pictures on the card.
struct FailedAttempt {
  WallTime from{};
  WallTime to{};
};

struct SessionShots {
  std::vector<ExposedStation> stations;  // in order of time
  std::vector<FailedAttempt> failed;     // in order of time
  int exposures = 1;                     // pictures per station
};

struct StationPictures {
  std::size_t station = 0;         // index into SessionShots::stations
  std::vector<std::size_t> shots;  // indices into CardPictures::shots, one per exposure
};

struct PictureMatch {
  bool by_name = false;                     // not by time; nothing is known of the clocks
  std::vector<StationPictures> complete;    // all exposures found
  std::vector<StationPictures> incomplete;  // exposures missing, and not imported before
  std::vector<std::size_t> from_failed;     // shots of failed attempts
  std::vector<std::size_t> unassigned;      // shots that belong to no station
  double clock_offset_s = 0.0;              // camera's clock minus the session's, at the start
  double clock_drift = 0.0;                 // growth of the offset per second
  double rms_s = 0.0;                       // of the residuals after offset and drift
};

// Matches by count, order and time; the camera's clock may have any offset and a drift of up to
// 1e-4 (align_times.h). Throws Error if the assignment is ambiguous, or if fewer than half of the
// pictures and of the stations match, as with pictures of another session.
PictureMatch match_pictures(const SessionShots& session, const CardPictures& card);

// Assigns all pictures, in order of their names and whatever their times, to the stations from
// `first_station` on in the order of capture. Throws Error if no picture of that station is on the
// card, a bracket is not complete, or the stations are fewer.
PictureMatch assign_by_name(const SessionShots& session, const CardPictures& card,
                            const std::string& first_station);

// Whether every picture and every station has a counterpart.
bool is_complete(const PictureMatch& match, const CardPictures& card);

// One line for the user: stations with missing pictures and pictures without a station. Empty if
// the match is complete.
std::string describe_mismatches(const PictureMatch& match, const SessionShots& session,
                                const CardPictures& card);

}  // namespace raywalk::capture
