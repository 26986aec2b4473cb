#include "simulator/rig/camera_faults.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

constexpr std::array kFaults = {CameraFault::kBusy,
                                CameraFault::kMissingPicture,
                                CameraFault::kTruncatedPicture,
                                CameraFault::kEmptyPicture,
                                CameraFault::kWrongSize,
                                CameraFault::kCardFull,
                                CameraFault::kForgetsExposure,
                                CameraFault::kWebPage,
                                CameraFault::kSilent,
                                CameraFault::kDown};

}  // namespace

std::string_view name_of(CameraFault fault) {
  switch (fault) {
    case CameraFault::kBusy:
      return "busy";
    case CameraFault::kMissingPicture:
      return "missing-picture";
    case CameraFault::kTruncatedPicture:
      return "truncated-picture";
    case CameraFault::kEmptyPicture:
      return "empty-picture";
    case CameraFault::kWrongSize:
      return "wrong-size";
    case CameraFault::kCardFull:
      return "card-full";
    case CameraFault::kForgetsExposure:
      return "forgets-exposure";
    case CameraFault::kWebPage:
      return "web-page";
    case CameraFault::kSilent:
      return "silent";
    case CameraFault::kDown:
      return "down";
  }
  throw std::logic_error("unknown fault of a camera");
}

const std::vector<std::string>& camera_fault_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    all.reserve(std::size(kFaults));
    for (const CameraFault fault : kFaults) all.emplace_back(name_of(fault));
    return all;
  }();
  return names;
}

CameraFault camera_fault_named(std::string_view name) {
  for (const CameraFault fault : kFaults) {
    if (name_of(fault) == name) return fault;
  }
  std::string known;
  for (const std::string& each : camera_fault_names()) known += (known.empty() ? "" : ", ") + each;
  throw UsageError("unknown camera fault " + excerpt(name) + "; use one of " + known);
}

void CameraFaults::inject(CameraFault fault, double for_ms) {
  const std::lock_guard lock(mutex_);
  if (for_ms > 0.0) {
    SteadyTime& until = until_[fault];
    until = std::max(until, clock_.now() + duration_from_ms(for_ms));
  } else {
    ++pending_[fault];
  }
}

void CameraFaults::schedule(CameraFault fault, std::uint64_t at_picture) {
  const std::lock_guard lock(mutex_);
  planned_.insert({fault, at_picture});
}

void CameraFaults::clear() {
  const std::lock_guard lock(mutex_);
  pending_.clear();
  until_.clear();
  planned_.clear();
}

bool CameraFaults::occurs(CameraFault fault) {
  const std::lock_guard lock(mutex_);
  const auto waiting = pending_.find(fault);
  const bool once = waiting != pending_.end() && waiting->second > 0;
  if (once) --waiting->second;
  const bool now = once || lasts_locked(fault);
  if (now) ++occurred_;
  return now;
}

bool CameraFaults::occurs_at_picture(CameraFault fault, std::uint64_t picture) {
  {
    const std::lock_guard lock(mutex_);
    if (planned_.erase({fault, picture}) > 0) {
      ++occurred_;
      return true;
    }
  }
  return occurs(fault);
}

bool CameraFaults::lasts(CameraFault fault) const {
  const std::lock_guard lock(mutex_);
  return lasts_locked(fault);
}

bool CameraFaults::lasts_locked(CameraFault fault) const {
  const auto until = until_.find(fault);
  return until != until_.end() && clock_.now() < until->second;
}

std::uint64_t CameraFaults::occurred() const {
  const std::lock_guard lock(mutex_);
  return occurred_;
}

}  // namespace raywalk::capture
