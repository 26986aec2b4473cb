// What a device can do wrong, as an error that says what to do about it.
#pragma once

#include <string>
#include <string_view>

#include "core/base/error.h"

namespace raywalk::capture {

enum class FaultKind {
  kNoContact,       // no answer, or only damaged ones, after every retry
  kWrongDevice,     // answers, but not as the configuration says it would
  kAlarm,           // the drive reports an alarm
  kStall,           // told to move and does not
  kFollowingError,  // is not where it should be on its way, or stopped short
  kLimitSwitch,     // ran into a limit switch, or left the soft limits
  kTimeout,         // did not finish in time
  kBusy,            // the camera stays busy
  kCardFull,        // no room for the next picture
  kMissingPicture,  // fewer pictures than were asked for
  kBadPicture,      // empty, cut short, of another size, or no picture at all
  kExposure,        // exposure or white balance is not what was locked
};

// The word that the session's database holds for it: "no-contact", "stall", ...
std::string_view name_of(FaultKind kind);

// A device failed. The message is one line: what happened, and after a semicolon what to do next.
class DeviceFault : public Error {
 public:
  DeviceFault(FaultKind kind, const std::string& what) : Error(what), kind_(kind) {}

  FaultKind kind() const { return kind_; }
  // Whether shooting the same station again may help: a picture that did not arrive whole. A
  // slider's fault never is retried unseen: the operator looks first.
  bool worth_another_shot() const {
    return kind_ == FaultKind::kMissingPicture || kind_ == FaultKind::kBadPicture;
  }

 private:
  FaultKind kind_;
};

}  // namespace raywalk::capture
