// The estimated duration of a capture.
#pragma once

#include <string>

#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

// Seconds. Motion includes the moves between stations and to the start of the next placement of the
// rail, and homing once.
struct CaptureTime {
  double motion_s = 0.0;
  double settling_s = 0.0;
  double pictures_s = 0.0;
  double placing_s = 0.0;  // of the rail, once per placement
  double total_s() const { return motion_s + settling_s + pictures_s + placing_s; }
};

// Seconds from the trigger to the pictures of a station on the disk, for all its exposures:
// run.picture_s if set, else an estimate from the waiting times in the camera's configuration and
// the usual times of its kind of camera.
double picture_s(const CaptureConfig& config);

// Seconds that homing takes, taken as one move along the whole rail.
double homing_s(const CaptureConfig& config);

CaptureTime estimate_time(const CapturePlan& plan, const CaptureConfig& config);

// "7.5 s", "45 s", "12 min", "3 h 05 min".
std::string duration_text(double seconds);

}  // namespace raywalk::capture
