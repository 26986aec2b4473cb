#include "capture/base/device_fault.h"

#include <stdexcept>

namespace raywalk::capture {

std::string_view name_of(FaultKind kind) {
  switch (kind) {
    case FaultKind::kNoContact:
      return "no-contact";
    case FaultKind::kWrongDevice:
      return "wrong-device";
    case FaultKind::kAlarm:
      return "alarm";
    case FaultKind::kStall:
      return "stall";
    case FaultKind::kFollowingError:
      return "following-error";
    case FaultKind::kLimitSwitch:
      return "limit-switch";
    case FaultKind::kTimeout:
      return "timeout";
    case FaultKind::kBusy:
      return "busy";
    case FaultKind::kCardFull:
      return "card-full";
    case FaultKind::kMissingPicture:
      return "missing-picture";
    case FaultKind::kBadPicture:
      return "bad-picture";
    case FaultKind::kExposure:
      return "exposure";
  }
  throw std::logic_error("unknown kind of fault");
}

}  // namespace raywalk::capture
