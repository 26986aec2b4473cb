#include "simulator/rig/rig_faults.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/files/words.h"

namespace raywalk::capture {
namespace {

constexpr std::array<std::pair<std::string_view, DriveFault>, 6> kDriveFaults{
    {{"stall", DriveFault::kStall},
     {"alarm", DriveFault::kAlarm},
     {"low-limit", DriveFault::kLowLimit},
     {"high-limit", DriveFault::kHighLimit},
     {"feedback-jump", DriveFault::kFeedbackJump},
     {"feedback-drift", DriveFault::kFeedbackDrift}}};

constexpr std::array<std::pair<std::string_view, LinkFault>, 7> kLinkFaults{
    {{"late", LinkFault::kLate},
     {"lost-request", LinkFault::kLostRequest},
     {"lost-reply", LinkFault::kLostReply},
     {"corrupted-request", LinkFault::kCorruptedRequest},
     {"corrupted-reply", LinkFault::kCorruptedReply},
     {"duplicated", LinkFault::kDuplicated},
     {"cut", LinkFault::kCut}}};

template <typename Kinds>
auto find_kind(const Kinds& kinds, std::string_view word)
    -> std::optional<typename Kinds::value_type::second_type> {
  for (const auto& [name, fault] : kinds) {
    if (name == word) return fault;
  }
  return std::nullopt;
}

bool is_camera_fault(const std::string& kind) {
  const auto& names = camera_fault_names();
  return std::find(names.begin(), names.end(), kind) != names.end();
}

// Camera faults that affect a request rather than a picture.
bool is_at_trigger(CameraFault fault) {
  return fault != CameraFault::kWebPage && fault != CameraFault::kSilent &&
         fault != CameraFault::kDown;
}

// The target is rounded to whole steps, so it may differ slightly from the station.
constexpr double kSamePlace_mm = 0.1;

std::chrono::milliseconds rounded_ms(double ms) {
  return std::chrono::milliseconds(std::llround(ms));
}

}  // namespace

const std::vector<std::string>& rig_fault_kinds() {
  static const std::vector<std::string> kinds = [] {
    std::vector<std::string> all;
    all.reserve(kDriveFaults.size() + kLinkFaults.size() + camera_fault_names().size());
    for (const auto& entry : kDriveFaults) all.emplace_back(entry.first);
    for (const auto& entry : kLinkFaults) all.emplace_back(entry.first);
    all.insert(all.end(), camera_fault_names().begin(), camera_fault_names().end());
    return all;
  }();
  return kinds;
}

void require_valid(const ScheduledFault& scheduled, const std::string& where) {
  const std::string& kind = scheduled.fault.kind;
  const auto& kinds = rig_fault_kinds();
  if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
    throw UsageError(fmt::format("{}: unknown fault {}{}; use one of {}", where, excerpt(kind),
                                 suggestion(kind, kinds), fmt::join(kinds, ", ")));
  }
  const bool of_link = find_kind(kLinkFaults, kind).has_value();
  const bool of_camera = is_camera_fault(kind);
  const int waits = (scheduled.at_request > 0 ? 1 : 0) + (scheduled.at_picture > 0 ? 1 : 0) +
                    (scheduled.at_station.empty() ? 0 : 1) + (scheduled.at_s >= 0.0 ? 1 : 0);
  const char* allowed = of_link     ? "at_request, at_station or at_s"
                        : of_camera ? "at_picture or at_station"
                                    : "at_station or at_s";
  const bool fits =
      (scheduled.at_request == 0 || of_link) &&
      (scheduled.at_picture == 0 || (of_camera && is_at_trigger(camera_fault_named(kind)))) &&
      (scheduled.at_s < 0.0 || !of_camera);
  if (waits != 1 || !fits) {
    throw UsageError(fmt::format("{}: '{}' needs {} of {}", where, kind,
                                 waits == 1 ? "another trigger, one" : "exactly one", allowed));
  }
}

RigFaults::RigFaults(SimulatedDrive* drive, LinkFaults* link, SimulatedCamera* camera)
    : drive_(drive), link_(link), camera_(camera) {}

void RigFaults::inject(const FaultRequest& fault) {
  if (const auto drive_fault = find_kind(kDriveFaults, fault.kind)) {
    drive_->inject(*drive_fault, fault.amount, duration_from_ms(fault.for_ms),
                   duration_from_ms(fault.after_ms));
  } else if (const auto link_fault = find_kind(kLinkFaults, fault.kind)) {
    if (fault.after_ms > 0.0) {
      link_->schedule_in(*link_fault, rounded_ms(fault.after_ms), rounded_ms(fault.for_ms));
    } else if (*link_fault == LinkFault::kCut) {
      link_->cut(rounded_ms(fault.for_ms));
    } else {
      link_->inject(*link_fault, fault.requests);
    }
  } else {
    camera_->faults().inject(camera_fault_named(fault.kind), fault.for_ms);
  }
}

void RigFaults::schedule(const ScheduledFault& scheduled, const CapturePlan& plan) {
  const FaultRequest& fault = scheduled.fault;
  require_valid(scheduled, "fault '" + fault.kind + "'");
  if (scheduled.at_picture > 0) {
    camera_->faults().schedule(camera_fault_named(fault.kind),
                               static_cast<std::uint64_t>(scheduled.at_picture));
  } else if (scheduled.at_request > 0) {
    link_->schedule(*find_kind(kLinkFaults, fault.kind),
                    static_cast<std::uint64_t>(scheduled.at_request), rounded_ms(fault.for_ms));
  } else if (scheduled.at_s >= 0.0) {
    FaultRequest later = fault;
    later.after_ms += 1e3 * scheduled.at_s;
    inject(later);
  } else {
    for (const CaptureLine& line : plan.lines) {
      for (const CaptureStation& station : line.stations) {
        if (station.name != scheduled.at_station) continue;
        const std::lock_guard lock(mutex_);
        at_stations_.insert({line.id, {station.rail_mm, fault}});
        return;
      }
    }
    throw UsageError(fmt::format("fault '{}': the plan has no station {}", fault.kind,
                                 excerpt(scheduled.at_station)));
  }
}

void RigFaults::clear() {
  {
    const std::lock_guard lock(mutex_);
    at_stations_.clear();
  }
  drive_->clear_faults();
  link_->restore();
  camera_->restart();
}

void RigFaults::move_commanded(const std::string& line_id, double target_mm) {
  std::vector<FaultRequest> due;
  {
    const std::lock_guard lock(mutex_);
    auto [entry, end] = at_stations_.equal_range(line_id);
    while (entry != end) {
      const bool is_here = std::abs(entry->second.rail_mm - target_mm) <= kSamePlace_mm;
      if (is_here) due.push_back(entry->second.fault);
      entry = is_here ? at_stations_.erase(entry) : std::next(entry);
    }
  }
  for (const FaultRequest& fault : due) inject(fault);
}

}  // namespace raywalk::capture
