// The shots of a session whose camera keeps the pictures on its card.
#pragma once

#include "capture/import/match_pictures.h"
#include "capture/session/session_reader.h"

namespace raywalk::capture {

// Every station whose pictures were taken, and every failed attempt that may have left pictures on
// the card, both in order of time. Throws Error if the session's camera does not keep its pictures
// on a card, the session was captured as video, or no picture was taken.
SessionShots read_session_shots(SessionReader* reader);

}  // namespace raywalk::capture
