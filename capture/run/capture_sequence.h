// Captures a plan line by line, station by station: move, settle, trigger, store, commit.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/camera/camera.h"
#include "capture/plan/capture_plan.h"
#include "capture/run/place_rail.h"
#include "capture/session/session.h"
#include "capture/slider/carriage.h"

namespace raywalk::capture {

// The parts of a capture, which must outlive it.
struct CaptureParts {
  Carriage* carriage = nullptr;
  Camera* camera = nullptr;
  Session* session = nullptr;
  PlaceRail place_rail{};
  Clock* clock = nullptr;
};

struct CaptureRules {
  int shots = 3;      // tries per station while its picture arrives incomplete
  int exposures = 1;  // pictures per station
  FrameKind frames = FrameKind::kPanorama;  // what the first picture of each line must show
  // A line begins this far below its first station, so that every station is approached in the same
  // direction and the backlash of the drive is the same at all of them.
  double approach_mm = 5.0;
  double least_free_bytes = 0;  // required on the session's disk before every station
};

// The progress of the work, for messages.
struct WorkState {
  std::string place = "before the first line";  // "station x0_007"
  std::function<std::string()> done{};          // "12 of 44 stations captured"
};

// Runs `work`, which keeps `state` up to date. Turns an Error into Paused and adds place, progress
// and how to resume to its message, and to that of Interrupted. Records either as an event of the
// session.
void pause_on_error(Session* session, const WorkState& state, const std::function<void()>& work);

// The stations of the plan that are still to be captured.
std::size_t count_missing(const CapturePlan& plan, const Session& session);

// Captures every station of the plan that the session does not hold yet; the carriage must be
// homed. Throws Paused, naming station, fault and next step, if a device fails or the disk is full;
// and Interrupted. In either case the session holds everything captured so far.
class CaptureSequence {
 public:
  CaptureSequence(const CaptureParts& parts, const CaptureRules& rules)
      : parts_(parts), rules_(rules) {}

  void run(const CapturePlan& plan);

 private:
  void capture_lines(const CapturePlan& plan);
  void begin_line(const CaptureLine& line, const CaptureStation& first);
  void capture_station(const CaptureStation& station);
  void try_station(const CaptureStation& station);
  void shoot_station(const AttemptId& attempt, SafePosition target);
  std::vector<StoredFrame> store_pictures(const AttemptId& attempt, const Shot& shot);
  void require_pictures(const Shot& shot) const;
  void look_at_first_of_line(const Shot& shot);
  void require_space() const;
  double own_ms_since_last(const SettledPosition& settled, const Shot& shot);

  CaptureParts parts_;
  CaptureRules rules_;
  WorkState state_;
  bool line_begins_ = false;     // none of its pictures was looked at yet
  SteadyTime measured_until_{};  // end of the time that earlier stations account for
};

}  // namespace raywalk::capture
