#include "simulator/rig/faults.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace raywalk::simulator {
namespace {

constexpr double kLongestFault_ms = 1e9;

struct FaultEntry {
  std::string_view name;
  bool is_permanent = false;  // lasts until it is mended if it has no duration
};

// In the order of RigFault.
constexpr std::array<FaultEntry, 21> kKinds{{{"stall", true},
                                             {"alarm"},
                                             {"low-limit", true},
                                             {"high-limit", true},
                                             {"feedback-jump", true},
                                             {"feedback-drift", true},
                                             {"late"},
                                             {"lost-request"},
                                             {"lost-reply"},
                                             {"corrupted-reply"},
                                             {"duplicated"},
                                             {"cut", true},
                                             {"busy", true},
                                             {"missing-picture"},
                                             {"truncated-picture"},
                                             {"empty-picture"},
                                             {"card-full"},
                                             {"forgets-exposure"},
                                             {"web-page"},
                                             {"silent"},
                                             {"down"}}};

const FaultEntry& kind_of(RigFault kind) { return kKinds.at(static_cast<std::size_t>(kind)); }

bool occurs_once(const Fault& fault) {
  return fault.for_ms == 0.0 && !kind_of(fault.kind).is_permanent;
}

}  // namespace

std::string_view name_of(RigFault kind) { return kind_of(kind).name; }

SettingsSchema fault_schema(Fault* fault) {
  static const std::vector<RigFault> kinds = [] {
    std::vector<RigFault> all(kKinds.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<RigFault>(i);
    return all;
  }();
  constexpr int kMost = std::numeric_limits<int>::max();
  SettingsSchema schema;
  schema.choice("kind", &fault->kind, kinds)
      .integer("at_request", &fault->at_request, 1, kMost)
      .integer("at_picture", &fault->at_picture, 1, kMost)
      .text("at_station", &fault->at_station)
      .number("at_s", &fault->at_s, 0.0, 1e6)
      .number("after_ms", &fault->after_ms, 0.0, kLongestFault_ms)
      .number("for_ms", &fault->for_ms, 0.0, kLongestFault_ms)
      .number("amount", &fault->amount, -1e6, 1e6);
  return schema;
}

int triggers_of(const Fault& fault) {
  return (fault.at_request > 0 ? 1 : 0) + (fault.at_picture > 0 ? 1 : 0) +
         (fault.at_station.empty() ? 0 : 1) + (fault.at_s >= 0.0 ? 1 : 0);
}

Faults::Faults(const Clock* clock, const LinkSettings& link)
    : clock_(clock),
      link_(link),
      made_at_(clock->now()),
      chance_(hash_bits(static_cast<std::uint64_t>(link.seed), 0x11f0)) {}

void Faults::add(const Fault& fault) {
  const std::lock_guard lock(mutex_);
  entries_.push_back({fault});
  if (fault.at_s >= 0.0) begin(&entries_.back(), made_at_ + duration_from_ms(1e3 * fault.at_s));
  if (triggers_of(fault) == 0) begin(&entries_.back(), clock_->now());
}

void Faults::clear() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
}

void Faults::begin(Entry* entry, SteadyTime trigger) {
  entry->begin = trigger + duration_from_ms(entry->fault.after_ms);
  if (entry->fault.for_ms > 0.0) {
    entry->end = entry->begin + duration_from_ms(entry->fault.for_ms);
  }
}

template <typename Condition>
void Faults::begin_where(const Condition& condition) {
  for (Entry& entry : entries_) {
    const bool waits = entry.begin == SteadyTime::max();
    if (waits && condition(entry.fault)) begin(&entry, clock_->now());
  }
}

void Faults::picture_triggered(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  begin_where([number](const Fault& fault) {
    return fault.at_picture > 0 && static_cast<std::uint64_t>(fault.at_picture) == number;
  });
}

void Faults::move_commanded(const std::string& station) {
  const std::lock_guard lock(mutex_);
  begin_where([&station](const Fault& fault) {
    return !fault.at_station.empty() && fault.at_station == station;
  });
}

std::optional<RigFault> Faults::next_exchange() {
  using enum RigFault;
  const std::lock_guard lock(mutex_);
  ++exchanges_;
  begin_where([this](const Fault& fault) {
    return fault.at_request > 0 && static_cast<std::uint64_t>(fault.at_request) == exchanges_;
  });
  // Drawn for every exchange, so that other faults do not change the random sequence.
  const std::optional<RigFault> random = random_fault();
  for (const RigFault kind : {kLate, kLostRequest, kLostReply, kCorruptedReply, kDuplicated}) {
    if (take(kind, clock_->now())) return kind;
  }
  if (random) ++occurred_;
  return random;
}

// One random number selects the fault, another one the direction.
std::optional<RigFault> Faults::random_fault() {
  double left = chance_.uniform();
  const bool request = chance_.chance(0.5);
  const auto falls_in = [&left](double share) {
    left -= share;
    return left < 0.0;
  };
  if (falls_in(link_.late)) return RigFault::kLate;
  if (falls_in(link_.lost)) return request ? RigFault::kLostRequest : RigFault::kLostReply;
  if (falls_in(link_.corrupted)) {
    return request ? RigFault::kLostRequest : RigFault::kCorruptedReply;
  }
  if (falls_in(link_.duplicated)) return RigFault::kDuplicated;
  return std::nullopt;
}

std::optional<Faults::Lasting> Faults::lasting(RigFault kind, std::optional<SteadyTime> at) const {
  const std::lock_guard lock(mutex_);
  const SteadyTime time = at.value_or(clock_->now());
  for (const Entry& entry : entries_) {
    if (occurs_once(entry.fault) || !entry.is_on(kind, time)) continue;
    return Lasting{entry.begin, entry.fault.amount};
  }
  return std::nullopt;
}

std::optional<double> Faults::occurs(RigFault kind, std::optional<SteadyTime> by) {
  const std::lock_guard lock(mutex_);
  return take(kind, by.value_or(clock_->now()));
}

std::optional<double> Faults::take(RigFault kind, SteadyTime by) {
  const auto due = std::find_if(entries_.begin(), entries_.end(),
                                [&](const Entry& entry) { return entry.is_on(kind, by); });
  if (due == entries_.end()) return std::nullopt;
  ++occurred_;
  const double amount = due->fault.amount;
  if (occurs_once(due->fault)) entries_.erase(due);
  return amount;
}

std::optional<SteadyTime> Faults::next_change(SteadyTime time) const {
  const std::lock_guard lock(mutex_);
  SteadyTime next = SteadyTime::max();
  for (const Entry& entry : entries_) {
    for (const SteadyTime change : {entry.begin, entry.end}) {
      if (change > time) next = std::min(next, change);
    }
  }
  return next == SteadyTime::max() ? std::nullopt : std::optional(next);
}

std::uint64_t Faults::exchanges() const {
  const std::lock_guard lock(mutex_);
  return exchanges_;
}

std::uint64_t Faults::occurred() const {
  const std::lock_guard lock(mutex_);
  return occurred_;
}

}  // namespace raywalk::simulator
