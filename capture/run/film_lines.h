// Capture by film: the camera records while the slider moves slowly along each line, and a journal
// of the feedback tells afterwards where every picture was taken (raywalk-capture import --video).
#pragma once

#include "capture/run/capture_sequence.h"

namespace raywalk::capture {

struct FilmRules {
  MotionProfile profile{};   // of the slow pass
  double approach_mm = 5.0;  // as CaptureRules::approach_mm
  double still_ms = 2000.0;  // filmed at rest before and after the pass, to find its edges by
};

// Films every line that the session has no journal of. Throws Paused and Interrupted as
// CaptureSequence::run does; a line whose pass did not end well is filmed again.
void film_lines(const CapturePlan& plan, const CaptureParts& parts, const FilmRules& rules);

}  // namespace raywalk::capture
