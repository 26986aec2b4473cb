// How a session ends early without losing anything.
#pragma once

#include <functional>
#include <string>

#include "capture/session/session.h"

namespace raywalk::capture {

// What is going on, for whoever reads why it stopped.
struct WorkState {
  std::string place = "before the first line";  // "station x0_007"
  std::function<std::string()> done{};          // "12 of 44 stations captured"
};

// Does `work`, which keeps `state` true. An Error becomes Paused and Interrupted a new Interrupted,
// both with place, reason and how to go on; the session remembers either as an event.
void in_good_order(Session* session, const WorkState& state, const std::function<void()>& work);

}  // namespace raywalk::capture
