// How long a capture takes, estimated from its plan and configuration.
#pragma once

#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// Seconds that a move of `distance_mm` >= 0 takes from rest to rest.
double move_s(double distance_mm, const MotionProfile& profile);

// Seconds. Motion holds the moves between stations and back to the beginning of the next line, and
// homing, taken as one move along the whole rail.
struct CaptureTime {
  double motion_s = 0.0;
  double settling_s = 0.0;
  double pictures_s = 0.0;
  double placing_s = 0.0;  // of the rail, once per line
  double total_s() const { return motion_s + settling_s + pictures_s + placing_s; }
};

// Seconds from the trigger to the picture of a station on the disk, all its exposures included:
// run.picture_s where it is set, else what the camera's configuration says it waits, with what
// cameras of its kind usually take.
double picture_s(const CaptureConfig& config);

CaptureTime estimate_time(const CapturePlan& plan, const CaptureConfig& config);

}  // namespace raywalk::capture
