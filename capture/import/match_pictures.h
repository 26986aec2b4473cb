// Which picture of a camera's card belongs to which station of a session.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "capture/import/card_pictures.h"

namespace raywalk::capture {

// A station whose pictures were taken and stayed on the card.
struct ExposedStation {
  AttemptId attempt;  // that took them
  WallTime from{};    // its pictures were taken between these, by the session's clock
  WallTime to{};
  bool imported = false;  // by an earlier import
};

// A try that failed or was cut short, and may have left pictures on the card.
struct AbandonedAttempt {
  WallTime from{};
  WallTime to{};
};

struct SessionShots {
  std::vector<ExposedStation> stations;     // in order of time
  std::vector<AbandonedAttempt> abandoned;  // in order of time
  int exposures = 1;                        // pictures per station
};

struct StationPictures {
  std::size_t station = 0;         // index into SessionShots::stations
  std::vector<std::size_t> shots;  // indices into CardPictures::shots, one per exposure
};

struct PictureMatch {
  std::vector<StationPictures> complete;    // all exposures found
  std::vector<StationPictures> incomplete;  // some or none found, and not imported before
  std::vector<std::size_t> of_abandoned;    // shots taken in a try that failed
  std::vector<std::size_t> of_none;         // shots that belong to no station
  double clock_offset_s = 0.0;              // camera's clock minus the session's, at the start
  double clock_drift = 0.0;                 // growth of it per second
  double rms_s = 0.0;                       // of what offset and drift leave over
};

// Matches by count, order and time; the camera's clock may be off by any offset and drift by
// 1e-4 (align_times.h). Throws Error where the times leave the assignment open, or where fewer than
// half of the pictures and of the stations find each other: they are of another session then.
PictureMatch match_pictures(const SessionShots& session, const CardPictures& card);

// Whether every picture and every station has found its counterpart.
bool is_whole(const PictureMatch& match, const CardPictures& card);

// One line: which stations lack what, which pictures belong to no station, and why.
std::string account_of(const PictureMatch& match, const SessionShots& session,
                       const CardPictures& card);

}  // namespace raywalk::capture
