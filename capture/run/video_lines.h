// Capture by video: the camera records while the slider moves slowly along each line. A journal of
// the slider's feedback later gives the position of every picture (raywalk-capture import --video).
#pragma once

#include "capture/run/capture_sequence.h"

namespace raywalk::capture {

struct VideoRules {
  MotionProfile profile{};   // of the slow pass
  double approach_mm = 5.0;  // as CaptureRules::approach_mm
  double still_ms = 2000.0;  // at rest before and after the pass, to detect its ends
};

// Records every line that the session has no journal of. Throws Paused and Interrupted as
// CaptureSequence::run does; a line whose pass failed has no journal and is recorded again on
// resume.
void record_lines(const CapturePlan& plan, const CaptureParts& parts, const VideoRules& rules);

}  // namespace raywalk::capture
