// Ends a session early in a state that can be resumed.
#pragma once

#include <functional>
#include <string>

#include "capture/session/session.h"

namespace raywalk::capture {

// The progress of the work, for messages.
struct WorkState {
  std::string place = "before the first line";  // "station x0_007"
  std::function<std::string()> done{};          // "12 of 44 stations captured"
};

// Runs `work`, which keeps `state` up to date. Turns an Error into Paused and adds place, progress
// and how to resume to its message, and to that of Interrupted. Records either as an event of the
// session.
void pause_on_error(Session* session, const WorkState& state, const std::function<void()>& work);

}  // namespace raywalk::capture
