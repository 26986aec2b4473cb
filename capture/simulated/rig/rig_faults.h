// Everything that the rig can do wrong, by its words: at once, or when something happens.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "capture/plan/capture_plan.h"
#include "capture/simulated/rig/link_faults.h"
#include "capture/simulated/rig/simulated_camera.h"
#include "capture/simulated/rig/simulated_drive.h"

namespace raywalk::capture {

// configs/simulated-rig.yaml explains the kinds and what the numbers mean to each.
struct FaultRequest {
  std::string kind{};
  double for_ms = 0.0;
  double after_ms = 0.0;
  double amount = 0.0;
  int requests = 1;
};

// A fault that waits for one of these.
struct ScheduledFault {
  FaultRequest fault{};
  int at_request = 0;        // of the Modbus link, from 1
  int at_picture = 0;        // the camera's triggers, from 1
  std::string at_station{};  // when the slider is sent there
  double at_s = -1.0;        // after the rig has started
};

// Every kind of fault: the slider's, the link's and the camera's.
const std::vector<std::string>& rig_fault_kinds();

// Throws UsageError, starting with `where`: an unknown kind, not exactly one thing to wait for, or
// one that the kind cannot wait for.
void require_valid(const ScheduledFault& scheduled, const std::string& where);

// Safe to use from several threads.
class RigFaults {
 public:
  // All have to outlive it.
  RigFaults(SimulatedDrive* drive, LinkFaults* link, SimulatedCamera* camera);

  // Throws UsageError for an unknown kind, listing those there are.
  void inject(const FaultRequest& fault);
  // Throws UsageError as require_valid does, or for a station that the plan does not have.
  void schedule(const ScheduledFault& scheduled, const CapturePlan& plan);
  // Mends everything and forgets what is scheduled.
  void clear();

  // Has faults happen that wait for the station where the slider is now being sent.
  void move_commanded(const std::string& line_id, double target_mm);

 private:
  struct AtStation {
    double rail_mm = 0.0;
    FaultRequest fault{};
  };

  SimulatedDrive* drive_;
  LinkFaults* link_;
  SimulatedCamera* camera_;
  std::mutex mutex_;
  std::multimap<std::string, AtStation> at_stations_;  // by line
};

}  // namespace raywalk::capture
