#include "simulator/rig/link_faults.h"

namespace raywalk::capture {

LinkFaults::LinkFaults(const LinkFaultRates& rates)
    : rates_(rates),
      chance_(hash_bits(static_cast<std::uint64_t>(rates.seed), 0x11f0)),
      damage_(hash_bits(static_cast<std::uint64_t>(rates.seed), 0xda3a)) {}

LinkFault LinkFaults::next() {
  const std::lock_guard lock(mutex_);
  ++requests_;
  // Drawn for every request, so that scheduled faults do not change the random sequence.
  LinkFault fault = random_fault();
  const auto scheduled = schedule_.find(requests_);
  if (injected_left_ > 0) {
    --injected_left_;
    fault = injected_;
  } else if (scheduled != schedule_.end()) {
    fault = scheduled->second.fault;
    if (fault == LinkFault::kCut) begin_cut(scheduled->second.cut_for);
  } else if (!timed_.empty() && timed_.begin()->first <= std::chrono::steady_clock::now()) {
    fault = timed_.begin()->second.fault;
    if (fault == LinkFault::kCut) begin_cut(timed_.begin()->second.cut_for);
    timed_.erase(timed_.begin());
  }
  if (fault != LinkFault::kNone) ++faults_;
  return fault;
}

// One random number selects the fault, another one the direction.
LinkFault LinkFaults::random_fault() {
  double left = chance_.uniform();
  const bool request = chance_.chance(0.5);
  const auto falls_in = [&left](double share) {
    left -= share;
    return left < 0.0;
  };
  if (falls_in(rates_.late)) return LinkFault::kLate;
  if (falls_in(rates_.lost)) return request ? LinkFault::kLostRequest : LinkFault::kLostReply;
  if (falls_in(rates_.corrupted)) {
    return request ? LinkFault::kCorruptedRequest : LinkFault::kCorruptedReply;
  }
  if (falls_in(rates_.duplicated)) return LinkFault::kDuplicated;
  return LinkFault::kNone;
}

void LinkFaults::inject(LinkFault fault, int requests) {
  const std::lock_guard lock(mutex_);
  injected_ = fault;
  injected_left_ = requests;
}

void LinkFaults::schedule(LinkFault fault, std::uint64_t at_request,
                          std::chrono::milliseconds cut_for) {
  const std::lock_guard lock(mutex_);
  schedule_[at_request] = {fault, cut_for};
}

void LinkFaults::schedule_in(LinkFault fault, std::chrono::milliseconds delay,
                             std::chrono::milliseconds cut_for) {
  const std::lock_guard lock(mutex_);
  timed_.emplace(std::chrono::steady_clock::now() + delay, Scheduled{fault, cut_for});
}

// Cuts begin at their time, even without a request.
void LinkFaults::begin_timed_cuts() {
  const auto now = std::chrono::steady_clock::now();
  for (auto timed = timed_.begin(); timed != timed_.end() && timed->first <= now;) {
    if (timed->second.fault == LinkFault::kCut) {
      begin_cut(timed->second.cut_for);
      ++faults_;
      timed = timed_.erase(timed);
    } else {
      ++timed;
    }
  }
}

void LinkFaults::begin_cut(std::chrono::milliseconds duration) {
  cut_ = true;
  cut_until_.reset();
  if (duration.count() > 0) cut_until_ = std::chrono::steady_clock::now() + duration;
}

void LinkFaults::cut(std::chrono::milliseconds duration) {
  const std::lock_guard lock(mutex_);
  begin_cut(duration);
  ++faults_;
}

void LinkFaults::restore() {
  const std::lock_guard lock(mutex_);
  cut_ = false;
  injected_left_ = 0;
  schedule_.clear();
  timed_.clear();
}

bool LinkFaults::is_cut() {
  const std::lock_guard lock(mutex_);
  begin_timed_cuts();
  return cut_ && (!cut_until_ || std::chrono::steady_clock::now() < *cut_until_);
}

ModbusBytes LinkFaults::corrupt(std::span<const std::uint8_t> bytes) {
  const std::lock_guard lock(mutex_);
  ModbusBytes damaged(bytes.begin(), bytes.end());
  if (damaged.empty()) return damaged;
  if (damage_.chance(0.25)) {
    damaged.pop_back();
  } else {
    const int bit = damage_.below(static_cast<int>(8 * damaged.size()));
    damaged[static_cast<std::size_t>(bit / 8)] ^= static_cast<std::uint8_t>(1U << (bit % 8));
  }
  return damaged;
}

std::chrono::microseconds LinkFaults::reply_delay() const {
  return std::chrono::microseconds(static_cast<std::int64_t>(1e3 * rates_.late_ms));
}

std::uint64_t LinkFaults::requests() const {
  const std::lock_guard lock(mutex_);
  return requests_;
}

std::uint64_t LinkFaults::faults() const {
  const std::lock_guard lock(mutex_);
  return faults_;
}

}  // namespace raywalk::capture
