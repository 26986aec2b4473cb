// Errors of devices: the kind of the fault and a message that says what to do.
#pragma once

#include <string>
#include <string_view>

#include "capture/base/word_of.h"
#include "core/base/error.h"

namespace raywalk::capture {

enum class FaultKind {
  kNoContact,       // no answer, or only damaged ones, after every retry
  kWrongDevice,     // answers, but is not the configured device
  kAlarm,           // the drive reports an alarm
  kStall,           // commanded to move, but does not
  kFollowingError,  // too far off its planned motion, or stopped short of the target
  kLimitSwitch,     // reached a limit switch, or left the soft limits
  kTimeout,         // did not finish in time
  kBusy,            // the camera stays busy
  kCardFull,        // no room for another picture on the camera's card
  kMissingPicture,  // fewer pictures than requested
  kBadPicture,      // empty, truncated, of another size, or not a picture
  kExposure,        // exposure or white balance differs from the locked values
};

// The name in the session's database: "no-contact", "stall", ...
constexpr std::string_view name_of(FaultKind kind) {
  return word_of(kind,
                 {"no-contact", "wrong-device", "alarm", "stall", "following-error", "limit-switch",
                  "timeout", "busy", "card-full", "missing-picture", "bad-picture", "exposure"});
}

// A device failed. The message is one line: what happened, and after a semicolon what to do next.
class DeviceFault : public Error {
 public:
  DeviceFault(FaultKind kind, const std::string& what) : Error(what), kind_(kind) {}

  FaultKind kind() const { return kind_; }
  // Whether shooting the same station again may help: only after an incomplete picture. Faults of
  // the slider are never retried, since an operator has to look at the rail first.
  bool is_retryable() const {
    return kind_ == FaultKind::kMissingPicture || kind_ == FaultKind::kBadPicture;
  }

 private:
  FaultKind kind_;
};

}  // namespace raywalk::capture
