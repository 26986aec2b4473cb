// What a session knows of the pictures that its camera keeps.
#pragma once

#include "capture/import/match_pictures.h"
#include "capture/session/session_reader.h"

namespace raywalk::capture {

// Every station whose pictures were taken, and every try that may have left pictures on the card,
// both in order of time. Throws Error: the session's camera keeps no pictures, or none was taken.
SessionShots read_session_shots(SessionReader* reader);

}  // namespace raywalk::capture
