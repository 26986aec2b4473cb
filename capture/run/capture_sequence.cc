#include "capture/run/capture_sequence.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "capture/base/device_fault.h"
#include "capture/base/units.h"
#include "capture/camera/check_picture.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"

namespace raywalk::capture {
namespace {

// The stations of a line that are still to be captured, in order.
std::vector<const CaptureStation*> missing_stations(const CaptureLine& line,
                                                    const Session& session) {
  std::vector<const CaptureStation*> missing;
  for (const CaptureStation& station : line.stations) {
    if (!session.is_captured(station.name)) missing.push_back(&station);
  }
  return missing;
}

// The user must see the original error, even if the session cannot be written any more. An attempt
// without an end is marked as failed when the session is opened again.
void try_to_record(const std::function<void()>& record) {
  try {
    record();
  } catch (const Error& error) {
    spdlog::warn("{}", error.what());
  }
}

}  // namespace

void pause_on_error(Session* session, const WorkState& state, const std::function<void()>& work) {
  try {
    work();
  } catch (const Interrupted&) {
    try_to_record([&] { session->record_event("interrupted", state.place); });
    throw Interrupted(
        fmt::format("interrupted at {}; the slider is at rest, {}; the same command resumes",
                    state.place, state.done()));
  } catch (const Error& error) {
    try_to_record([&] { session->record_event("paused", state.place + ": " + error.what()); });
    throw Paused(fmt::format("{}: {}. Paused with {}; the same command resumes", state.place,
                             error.what(), state.done()));
  }
}

std::size_t count_missing(const CapturePlan& plan, const Session& session) {
  std::size_t count = 0;
  for (const CaptureLine& line : plan.lines) count += missing_stations(line, session).size();
  return count;
}

void CaptureSequence::run(const CapturePlan& plan) {
  const Session& session = *parts_.session;
  state_.done = [&] {
    return fmt::format("{} of {} stations captured", plan.stations() - count_missing(plan, session),
                       plan.stations());
  };
  pause_on_error(parts_.session, state_, [&] { capture_lines(plan); });
  parts_.session->record_event("finished", state_.done());
}

void CaptureSequence::capture_lines(const CapturePlan& plan) {
  Progress progress("capture", static_cast<std::int64_t>(count_missing(plan, *parts_.session)),
                    "stations");
  const std::vector<CaptureLine> placements = placements_of(plan);
  const int count = static_cast<int>(placements.size());
  for (int i = 0; i < count; ++i) {
    const CaptureLine& line = placements[i];
    const auto missing = missing_stations(line, *parts_.session);
    if (missing.empty()) continue;
    state_.place = "line " + line.id;
    parts_.place_rail(line, i + 1, count);
    begin_line(line, *missing.front());
    for (const CaptureStation* station : missing) {
      state_.place = "station " + station->name;
      capture_station(*station);
      progress.advance();
    }
  }
}

void CaptureSequence::begin_line(const CaptureLine& line, const CaptureStation& first) {
  parts_.session->record_event("line-placed", line.id);
  const SoftLimits& limits = parts_.carriage->limits();
  const double start_mm = std::max(limits.low_mm(), first.rail_mm - rules_.approach_mm);
  parts_.carriage->move_to(limits.require(start_mm, "start of line " + line.id));
  line_begins_ = true;
  measured_until_ = parts_.clock->now();
}

void CaptureSequence::capture_station(const CaptureStation& station) {
  for (int shot = 1;; ++shot) {
    try {
      try_station(station);
      return;
    } catch (const DeviceFault& fault) {
      if (!fault.is_retryable() || shot >= rules_.shots) throw;
      spdlog::warn("station {}: {}; shooting it again ({} of {})", station.name, fault.what(),
                   shot + 1, rules_.shots);
      measured_until_ = parts_.clock->now();  // the camera's time, not the program's own
    }
  }
}

void CaptureSequence::try_station(const CaptureStation& station) {
  throw_if_interrupted();
  require_space();
  const SafePosition target =
      parts_.carriage->limits().require(station.rail_mm, "planned position");
  const AttemptId attempt = parts_.session->begin_attempt(station.name, target.mm());
  const auto record_failure = [&](std::string_view fault, const std::string& message) {
    try_to_record([&] { parts_.session->fail_attempt(attempt, fault, message); });
  };
  try {
    shoot_station(attempt, target);
  } catch (const DeviceFault& fault) {
    record_failure(name_of(fault.kind()), fault.what());
    throw;
  } catch (const Interrupted& interrupted) {
    record_failure("interrupted", interrupted.what());
    throw;
  } catch (const Error& error) {
    record_failure("session", error.what());
    throw;
  }
}

void CaptureSequence::shoot_station(const AttemptId& attempt, SafePosition target) {
  const SettledPosition settled = parts_.carriage->move_to(target);
  const Shot shot = parts_.camera->shoot(settled.settled_at);
  require_pictures(shot);
  look_at_first_of_line(shot);
  const std::vector<StoredFrame> frames = store_pictures(attempt, shot);
  parts_.session->complete_attempt(attempt, settled, shot, frames,
                                   own_ms_since_last(settled, shot));
}

std::vector<StoredFrame> CaptureSequence::store_pictures(const AttemptId& attempt,
                                                         const Shot& shot) {
  std::vector<StoredFrame> frames;
  for (const Picture& picture : shot.pictures) {
    const int exposure = static_cast<int>(frames.size());
    frames.push_back(parts_.session->store_frame(attempt, exposure, picture));
  }
  return frames;
}

void CaptureSequence::require_pictures(const Shot& shot) const {
  if (parts_.camera->keeps_pictures()) return;
  if (static_cast<int>(shot.pictures.size()) != rules_.exposures) {
    throw DeviceFault(FaultKind::kMissingPicture,
                      fmt::format("the camera gave {} pictures instead of {}; check its card and "
                                  "settings",
                                  shot.pictures.size(), rules_.exposures));
  }
  const PanoramaSize expected = parts_.session->frame_size().value_or(shot.pictures[0].size);
  for (const Picture& picture : shot.pictures) {
    if (picture.size == expected) continue;
    throw DeviceFault(
        FaultKind::kBadPicture,
        fmt::format("the picture is {} x {}, earlier ones are {} x {}; set the camera back to that "
                    "size",
                    picture.size.width, picture.size.height, expected.width, expected.height));
  }
}

// A camera that was set otherwise is noticed before a line of its pictures is captured.
void CaptureSequence::look_at_first_of_line(const Shot& shot) {
  if (!line_begins_ || shot.pictures.empty()) return;
  require_frame_kind(shot.pictures[0].bytes, rules_.frames, "the picture");
  line_begins_ = false;
}

void CaptureSequence::require_space() const {
  const std::filesystem::path& directory = parts_.session->directory();
  const auto free_bytes = static_cast<double>(std::filesystem::space(directory).available);
  if (free_bytes >= rules_.least_free_bytes) return;
  throw Error(
      fmt::format("{}: {:.0f} MB are free on its disk, less than the {:.0f} MB of "
                  "run.least_free_mb; free some",
                  directory.string(), free_bytes / kBytesPerMegabyte,
                  rules_.least_free_bytes / kBytesPerMegabyte));
}

// The time since the previous station that was neither motion, settling, exposure nor transfer. It
// includes the commit of the previous station.
double CaptureSequence::own_ms_since_last(const SettledPosition& settled, const Shot& shot) {
  const SteadyTime now = parts_.clock->now();
  const double passed_ms = ms_from_duration(now - measured_until_);
  measured_until_ = now;
  return passed_ms - settled.moving_ms - settled.settling_ms - shot.exposing_ms - shot.transfer_ms;
}

}  // namespace raywalk::capture
