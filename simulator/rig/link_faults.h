// Faults of the link between driver and drive, applied to requests and replies.
//
// Uses the system's steady clock rather than a simulated one, as do the timeouts of the client.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "simulator/room/hash_random.h"

namespace raywalk::capture {

using ModbusBytes = std::vector<std::uint8_t>;

// Probabilities per exchange, each 0 to 1, together at most 1.
struct LinkFaultRates {
  int seed = 1;
  double late = 0.0;
  double lost = 0.0;       // the request or the reply, equally likely
  double corrupted = 0.0;  // likewise
  double duplicated = 0.0;
  double late_ms = 800.0;  // delay of a late reply
};

enum class LinkFault {
  kNone,
  kLate,
  kLostRequest,  // the drive never receives it
  kLostReply,    // the drive has executed the request
  kCorruptedRequest,
  kCorruptedReply,
  kDuplicated,  // the reply arrives twice
  kCut,         // nothing is transmitted: the port hangs up, connections are reset
};

// Thread-safe. Random faults depend only on the seed and the number of the request.
class LinkFaults {
 public:
  explicit LinkFaults(const LinkFaultRates& rates);

  // The fault of the next request. Requests are counted from 1. Injected faults take precedence
  // over scheduled ones, and those over random ones.
  LinkFault next();
  // Applies the fault to the next `requests` requests; for kCut use cut().
  void inject(LinkFault fault, int requests);
  void schedule(LinkFault fault, std::uint64_t at_request, std::chrono::milliseconds cut_for);
  // Applies the fault to the first request after `delay`; a cut begins at that time.
  void schedule_in(LinkFault fault, std::chrono::milliseconds delay,
                   std::chrono::milliseconds cut_for);
  // Cuts the link for `duration`; zero: until restore().
  void cut(std::chrono::milliseconds duration);
  // Ends a cut and removes all injected and scheduled faults; random faults continue.
  void restore();
  bool is_cut();

  // Returns the bytes with one bit flipped or the last byte missing.
  ModbusBytes corrupt(std::span<const std::uint8_t> bytes);
  std::chrono::microseconds reply_delay() const;
  std::uint64_t requests() const;
  std::uint64_t faults() const;  // requests with a fault, plus cuts

 private:
  struct Scheduled {
    LinkFault fault = LinkFault::kNone;
    std::chrono::milliseconds cut_for{0};
  };
  LinkFault random_fault();
  void begin_timed_cuts();
  void begin_cut(std::chrono::milliseconds duration);

  const LinkFaultRates rates_;
  mutable std::mutex mutex_;
  HashRandom chance_;
  HashRandom damage_;
  std::uint64_t requests_ = 0;
  std::uint64_t faults_ = 0;
  LinkFault injected_ = LinkFault::kNone;
  int injected_left_ = 0;
  std::map<std::uint64_t, Scheduled> schedule_;
  std::multimap<std::chrono::steady_clock::time_point, Scheduled> timed_;
  bool cut_ = false;
  std::optional<std::chrono::steady_clock::time_point> cut_until_;
};

}  // namespace raywalk::capture
