// The faults of the rig's camera: which there are, and when they happen.
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
  kBusy,              // the command stays in progress and every other one is refused
  kMissingPicture,    // the command is done, but no file came of it
  kTruncatedPicture,  // the file ends after 60 % of its bytes
  kEmptyPicture,      // the file has no bytes
  kWrongSize,         // the picture has half its width and height
  kCardFull,          // the trigger is refused: no room
  kForgetsExposure,   // the camera falls back to automatic exposure and white balance
  // When a picture is fetched:
  kWebPage,  // a web page comes instead
  // At any request:
  kSilent,  // it is carried out, but not answered
  kDown,    // the connection is cut; if this lasts, nobody listens on the port
};

// The word for it in a configuration or a request: "busy", "missing-picture", "truncated-picture",
// "empty-picture", "wrong-size", "card-full", "forgets-exposure", "web-page", "silent", "down".
std::string_view name_of(CameraFault fault);
// All the words.
const std::vector<std::string>& camera_fault_names();
// Throws UsageError for a word that is none of them, listing them.
CameraFault camera_fault_named(std::string_view name);

// Which faults wait, last or are planned. Safe to use from several threads.
class CameraFaults {
 public:
  explicit CameraFaults(const Clock& clock) : clock_(clock) {}

  // Once, at the next opportunity (for_ms = 0), or at each one within the next for_ms of the clock.
  void inject(CameraFault fault, double for_ms = 0.0);
  // At one picture; the camera's triggers are counted from 1. For faults at a trigger.
  void schedule(CameraFault fault, std::uint64_t at_picture);
  // None waits, lasts or is planned any more.
  void clear();

  // Asked at each opportunity: whether the fault happens now. A single one is then spent.
  bool strikes(CameraFault fault);
  bool strikes_picture(CameraFault fault, std::uint64_t picture);
  // Whether a fault that was given a duration still lasts.
  bool lasts(CameraFault fault) const;
  // How many have happened.
  std::uint64_t struck() const;

 private:
  bool lasts_locked(CameraFault fault) const;

  const Clock& clock_;
  mutable std::mutex mutex_;
  std::map<CameraFault, int> waiting_;
  std::map<CameraFault, SteadyTime> until_;
  std::set<std::pair<CameraFault, std::uint64_t>> planned_;
  std::uint64_t struck_ = 0;
};

}  // namespace raywalk::capture
