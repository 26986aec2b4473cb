// Faults that can be injected into the simulated camera.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "capture/base/clock.h"

namespace raywalk::capture {

enum class CameraFault {
  // At a trigger:
  kBusy,              // the command stays in progress and all others are refused
  kMissingPicture,    // the command completes without a file
  kTruncatedPicture,  // the file ends after 60 % of its bytes
  kEmptyPicture,      // the file has no bytes
  kWrongSize,         // the picture has half its width and height
  kCardFull,          // the trigger is refused for lack of space
  kForgetsExposure,   // the camera falls back to automatic exposure and white balance
  // When a picture is fetched:
  kWebPage,  // a web page is sent instead
  // At any request:
  kSilent,  // the request is executed, but not answered
  kDown,    // the connection is closed; while it lasts, the port is closed
};

// Its name in configurations and requests: "busy", "missing-picture", "truncated-picture",
// "empty-picture", "wrong-size", "card-full", "forgets-exposure", "web-page", "silent", "down".
std::string_view name_of(CameraFault fault);
// All names.
const std::vector<std::string>& camera_fault_names();
// Throws UsageError listing the names if `name` is not one of them.
CameraFault camera_fault_named(std::string_view name);

// Pending, lasting and scheduled faults. Thread-safe.
class CameraFaults {
 public:
  explicit CameraFaults(const Clock& clock) : clock_(clock) {}

  // The fault occurs once, at the next opportunity (for_ms = 0), or at every opportunity during the
  // next for_ms milliseconds of the clock.
  void inject(CameraFault fault, double for_ms = 0.0);
  // The fault occurs at one picture, counted by triggers from 1. Only for faults at a trigger.
  void schedule(CameraFault fault, std::uint64_t at_picture);
  // Removes all faults.
  void clear();

  // Called at each opportunity; returns whether the fault occurs now. A fault injected once is then
  // consumed.
  bool occurs(CameraFault fault);
  bool occurs_at_picture(CameraFault fault, std::uint64_t picture);
  // Whether a fault with a duration still lasts.
  bool lasts(CameraFault fault) const;
  // Number of faults that have occurred.
  std::uint64_t occurred() const;

 private:
  bool lasts_locked(CameraFault fault) const;

  const Clock& clock_;
  mutable std::mutex mutex_;
  std::map<CameraFault, int> pending_;
  std::map<CameraFault, SteadyTime> until_;
  std::set<std::pair<CameraFault, std::uint64_t>> planned_;
  std::uint64_t occurred_ = 0;
};

}  // namespace raywalk::capture
