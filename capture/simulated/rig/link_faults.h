// What the line between driver and drive does to requests and replies.
//
// It runs on the machine's steady clock, not on a simulated one: the time-outs of the client that
// waits for a reply do too.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "capture/simulated/virtual_room/hash_random.h"

namespace raywalk::capture {

using ModbusBytes = std::vector<std::uint8_t>;

// Shares of all exchanges, each 0 to 1, together at most 1.
struct LinkFaultRates {
  int seed = 1;
  double late = 0.0;
  double lost = 0.0;       // the request or the reply, either as often
  double corrupted = 0.0;  // the same
  double duplicated = 0.0;
  double late_ms = 800.0;  // by how much a late reply is late
};

enum class LinkFault {
  kNone,
  kLate,
  kLostRequest,  // the drive never sees it
  kLostReply,    // the drive has done what it was told
  kCorruptedRequest,
  kCorruptedReply,
  kDuplicated,  // the reply arrives twice
  kCut,         // nothing arrives any more: the port hangs up, connections are reset
};

// Safe to use from several threads. The order of random faults follows from the seed and the number
// of the request alone.
class LinkFaults {
 public:
  explicit LinkFaults(const LinkFaultRates& rates);

  // What happens to the next request. Requests are counted from 1. A fault on request goes before
  // a scheduled one, that before chance.
  LinkFault next();
  // To the next `requests` requests; for a cut see cut().
  void inject(LinkFault fault, int requests);
  void schedule(LinkFault fault, std::uint64_t at_request, std::chrono::milliseconds cut_for);
  // To the first request so long from now, or a cut at that time.
  void schedule_in(LinkFault fault, std::chrono::milliseconds delay,
                   std::chrono::milliseconds cut_for);
  // Zero: until restore().
  void cut(std::chrono::milliseconds duration);
  // Ends a cut and all that was injected or scheduled; chance stays.
  void restore();
  bool is_cut();

  // The bytes with one bit flipped or the last one missing.
  ModbusBytes corrupt(std::span<const std::uint8_t> bytes);
  std::chrono::microseconds lateness() const;
  std::uint64_t requests() const;
  std::uint64_t faults() const;  // requests that had one, and cuts

 private:
  struct Scheduled {
    LinkFault fault = LinkFault::kNone;
    std::chrono::milliseconds cut_for{0};
  };
  LinkFault drawn();
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
