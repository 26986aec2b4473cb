// The progress of a session, for `raywalk-capture status`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "capture/session/session_database.h"

namespace raywalk::capture {

// Counts of every line, lost frames, failed attempts by fault, times, last events and the next
// step; docs/session.md lists the fields. Times are medians over the captured stations, null where
// none has the time; own_ms is what the program itself took of a station: all but motion, settling,
// exposure and transfer. Looks for every frame on the disk without reading it. Throws Error if the
// session cannot be read.
nlohmann::json session_status(SessionReader* session);

// The same as lines of text, the last one with the next step; each ends in a line break.
std::string status_text(const nlohmann::json& status);

}  // namespace raywalk::capture
