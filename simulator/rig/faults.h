// What goes wrong with the simulated rig: one list of faults for drive, link and camera, each with
// its trigger and its duration, and the random faults of the link.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/base/clock.h"
#include "core/files/settings.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {

using capture::Clock;
using capture::Duration;
using capture::duration_from_ms;
using capture::ms_from_duration;
using capture::SteadyTime;
using capture::WallTime;

// configs/simulated-rig.yaml explains them. What is permanent lasts until it is mended if it has no
// duration; the others then occur once.
enum class RigFault {
  // Of the drive, permanent except for the alarm, which lasts until it is reset:
  kStall,          // the motor is blocked while the drive reports motion
  kAlarm,          // amount: its code
  kLowLimit,       // the switch reads as pressed: the motor stops and refuses moves that way
  kHighLimit,      // likewise
  kFeedbackJump,   // amount: constant error of the feedback in millimetres
  kFeedbackDrift,  // amount: growth of that error in millimetres per second
  // Of an exchange over the link:
  kLate,
  kLostRequest,  // the drive never receives it
  kLostReply,    // the drive has executed the request
  kCorruptedReply,
  kDuplicated,  // the reply arrives twice
  kCut,         // permanent: the port hangs up, connections are closed
  // Of a picture:
  kBusy,              // permanent, from the next trigger on: the command stays in progress
  kMissingPicture,    // the command completes without a file
  kTruncatedPicture,  // the file ends after 60 % of its bytes
  kEmptyPicture,      // the file has no bytes
  kCardFull,          // the trigger is refused for lack of space
  kForgetsExposure,   // the camera falls back to automatic exposure and white balance
  kWebPage,           // sent instead of the picture when it is fetched
  // Of any request to the camera:
  kSilent,  // it is executed, but not answered
  kDown,    // the connection is closed
};

// As configurations and requests name it: "feedback-jump".
std::string_view name_of(RigFault kind);

struct Fault {
  RigFault kind = RigFault::kStall;
  double amount = 0.0;
  double for_ms = 0.0;    // 0: until mended if it is permanent, else once
  double after_ms = 0.0;  // from the trigger
  // The trigger: one of these; without one the fault begins when it is added.
  int at_request = 0;        // of the Modbus link, from 1
  int at_picture = 0;        // of the camera, from 1
  std::string at_station{};  // when a move to this station is commanded
  double at_s = -1.0;        // since the start of the rig
};

// The keys of a fault in a configuration and over HTTP, bound to `fault`.
SettingsSchema fault_schema(Fault* fault);
// The number of triggers that the fault has.
int triggers_of(const Fault& fault);

// Random faults of the link: probabilities per exchange, each 0 to 1, together at most 1. They
// depend only on the seed and the number of the exchange.
struct LinkSettings {
  int seed = 1;
  double late = 0.0;
  double lost = 0.0;       // the request or the reply, equally likely
  double corrupted = 0.0;  // likewise; a drive does not answer a corrupted request
  double duplicated = 0.0;
  double late_ms = 800.0;  // delay of a late reply
};

// Thread-safe; it never waits for the devices that ask it.
class Faults {
 public:
  // Time is that of the clock, which must outlive this object.
  explicit Faults(const Clock* clock, const LinkSettings& link = {});

  void add(const Fault& fault);
  // Ends all faults and drops those that wait for their trigger.
  void clear();

  // The triggers. Exchanges are counted here; the fault of this one, if any, is returned.
  std::optional<RigFault> next_exchange();
  void picture_triggered(std::uint64_t number);
  void move_commanded(const std::string& station);

  struct Lasting {
    SteadyTime since{};
    double amount = 0.0;
  };
  // The fault of a kind that is permanent or has a duration, if it lasts at a time (default: now).
  std::optional<Lasting> lasting(RigFault kind, std::optional<SteadyTime> at = {}) const;
  // Called where a fault can occur: its amount if it does, by that time. One without a duration is
  // then used up.
  std::optional<double> occurs(RigFault kind, std::optional<SteadyTime> by = {});
  // The next time after `time` when a fault begins or ends.
  std::optional<SteadyTime> next_change(SteadyTime time) const;

  const LinkSettings& link() const { return link_; }
  std::uint64_t exchanges() const;
  std::uint64_t occurred() const;  // faults of exchanges, pictures and requests so far, and alarms

 private:
  struct Entry {
    Fault fault{};
    SteadyTime begin = SteadyTime::max();  // max: waits for its trigger
    SteadyTime end = SteadyTime::max();    // max: until it is mended or used up

    bool is_on(RigFault kind, SteadyTime at) const {
      return fault.kind == kind && begin <= at && at < end;
    }
  };
  static void begin(Entry* entry, SteadyTime trigger);
  template <typename Condition>
  void begin_where(const Condition& condition);
  std::optional<double> take(RigFault kind, SteadyTime by);
  std::optional<RigFault> random_fault();

  const Clock* clock_;
  const LinkSettings link_;
  const SteadyTime made_at_;
  mutable std::mutex mutex_;
  HashRandom chance_;
  std::vector<Entry> entries_;
  std::uint64_t exchanges_ = 0;
  std::uint64_t occurred_ = 0;
};

}  // namespace raywalk::simulator
