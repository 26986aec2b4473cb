// All faults of the rig by name, injected immediately or scheduled.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "capture/plan/capture_plan.h"
#include "simulator/rig/link_faults.h"
#include "simulator/rig/simulated_camera.h"
#include "simulator/rig/simulated_drive.h"

namespace raywalk::capture {

// configs/simulated-rig.yaml documents the kinds and the meaning of the numbers for each.
struct FaultRequest {
  std::string kind{};
  double for_ms = 0.0;
  double after_ms = 0.0;
  double amount = 0.0;
  int requests = 1;
};

// A fault with exactly one of these triggers.
struct ScheduledFault {
  FaultRequest fault{};
  int at_request = 0;        // of the Modbus link, from 1
  int at_picture = 0;        // the camera's triggers, from 1
  std::string at_station{};  // when a move to this station is commanded
  double at_s = -1.0;        // since the start of the rig
};

// Every kind of fault: the slider's, the link's and the camera's.
const std::vector<std::string>& rig_fault_kinds();

// Throws UsageError, starting with `where`, if the kind is unknown, or if there is not exactly one
// trigger, valid for the kind.
void require_valid(const ScheduledFault& scheduled, const std::string& where);

// Safe to use from several threads.
class RigFaults {
 public:
  // The devices must outlive this object.
  RigFaults(SimulatedDrive* drive, LinkFaults* link, SimulatedCamera* camera);

  // Throws UsageError listing the kinds if the kind is unknown.
  void inject(const FaultRequest& fault);
  // Throws UsageError as require_valid does, or if the plan does not have the station.
  void schedule(const ScheduledFault& scheduled, const CapturePlan& plan);
  // Ends all faults and removes scheduled ones.
  void clear();

  // Called when a move is commanded; injects the faults scheduled for the station at the target.
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
