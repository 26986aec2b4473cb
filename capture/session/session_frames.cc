#include "capture/session/session_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <set>
#include <utility>

#include "capture/session/session.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/frame_list.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// What is wrong with a frame; empty where nothing is.
std::string fault_of(const SessionContents& contents, const SessionFrame& frame) {
  std::string fault = file_fault(contents, frame);
  if (!fault.empty()) return fault;
  fault = fmt::format("{} (station {}): ", frame.file, contents.station_of(frame).name);
  try {
    if (sha256_of_file(contents.directory / frame.file) == frame.sha256) return "";
    return fault + "changed since it was written (SHA-256 differs)";
  } catch (const Error& unreadable) {
    return fault + unreadable.what();
  }
}

bool has_frames(const SessionStation& station) { return station.shot && !station.shot->on_card; }

// Throws UsageError or Error unless the session can be exported as the options say.
void require_exportable(const SessionContents& contents, const SessionFacts& facts,
                        const ExportOptions& options) {
  const std::string directory = contents.directory.string();
  if (options.exposure < 0 || options.exposure >= facts.exposures()) {
    throw UsageError(
        fmt::format("{}: has {} exposure(s) of every station; --exposure takes 0 to {}", directory,
                    facts.exposures(), facts.exposures() - 1));
  }
  const std::vector<SessionStation>& stations = contents.stations;
  const auto first = std::ranges::find_if_not(stations, has_frames);
  if (!options.partial && first != stations.end()) {
    const auto planned = std::ranges::count_if(
        stations, [](const SessionStation& station) { return !station.shot; });
    const auto exposed = std::ranges::count_if(stations, [](const SessionStation& station) {
      return station.shot && station.shot->on_card;
    });
    throw Error(
        fmt::format("{}: {} of {} stations are not captured and the pictures of {} not "
                    "imported, the first is {}; finish with run or import, or export the "
                    "finished part with --partial",
                    directory, planned, stations.size(), exposed, first->name));
  }
  const bool halves = std::ranges::any_of(
      contents.frames, [](const SessionFrame& frame) { return frame.lens != FrameLens::kBoth; });
  if (!options.unstitched && (halves || facts.frames != FrameKind::kPanorama)) {
    throw Error(
        fmt::format("{}: its frames are fisheye pictures, not panoramas; stitch them with "
                    "raywalk-calibrate, or export them as they are with --unstitched",
                    directory));
  }
}

// What a partial export leaves out.
std::string left_out(const std::vector<SessionStation>& stations,
                     const SessionVerification& verification) {
  const auto captured = static_cast<std::size_t>(std::ranges::count_if(stations, has_frames));
  if (captured == stations.size()) return "";
  std::string text = fmt::format("; left out: {} of {} stations, not captured yet",
                                 stations.size() - captured, stations.size());
  if (!verification.leftover.empty()) {
    text += fmt::format(" ({} files in frames/ belong to no captured station)",
                        verification.leftover.size());
  }
  return text;
}

}  // namespace

SessionVerification verify_session(SessionReader* session) {
  // In this order, so that a frame stored by a run meanwhile is not taken for a leftover.
  const std::vector<std::string> files = list_frames(session->directory());
  const SessionContents contents = session->contents();
  const std::vector<SessionFrame>& frames = contents.frames;
  Progress progress("verifying", static_cast<std::int64_t>(frames.size()), "frames");
  std::vector<std::string> faults(frames.size());
  parallel_for(0, static_cast<int>(frames.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto index = static_cast<std::size_t>(i);
      faults[index] = fault_of(contents, frames[index]);
      progress.advance();
    }
  });
  SessionVerification verification{.faults = incomplete_stations(contents)};
  std::set<std::string> named;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ++verification.frames;
    verification.bytes += frames[i].bytes;
    named.insert(frames[i].file);
    if (faults[i].empty()) continue;
    verification.faults.push_back({contents.station_of(frames[i]).name, std::move(faults[i])});
  }
  std::ranges::copy_if(files, std::back_inserter(verification.leftover),
                       [&](const std::string& file) { return !named.contains(file); });
  return verification;
}

std::string verification_text(const SessionVerification& verification) {
  std::string text;
  for (const FrameFault& fault : verification.faults) text += fault.text + "\n";
  for (const std::string& file : verification.leftover) {
    text += file + ": belongs to no captured station (left by a run or a shot that failed)\n";
  }
  return text +
         fmt::format("{} frames of {:.1f} MB checked, {} wrong; {} files belong to no station\n",
                     verification.frames, static_cast<double>(verification.bytes) / 1e6,
                     verification.faults.size(), verification.leftover.size());
}

std::string give_up_lost_stations(const SessionVerification& verification, const fs::path& session,
                                  Clock* clock) {
  std::set<std::string> stations;
  for (const FrameFault& fault : verification.faults) stations.insert(fault.station);
  const std::unique_ptr<Session> writer = Session::open(session, clock);
  for (const std::string& station : stations) writer->give_up_frames(station);
  return fmt::format("{} given up; next: raywalk-capture status {}",
                     counted(stations.size(), "station"), escaped(session.string()));
}

std::string export_session(SessionReader* session, const ExportOptions& options) {
  const SessionContents contents = session->contents();
  require_exportable(contents, session->facts(), options);
  const SessionVerification verification = verify_session(session);
  require_no_faults(verification.faults, session->directory());
  std::vector<ListedFrame> grid, truth;
  std::set<std::string> lines;  // of the grid
  for (const SessionFrame& frame : contents.frames) {
    if (frame.exposure != options.exposure) continue;
    const SessionLine& line = contents.line_of(contents.station_of(frame));
    (line.validation ? truth : grid)
        .push_back({.file = frame.file,
                    .position_m = {frame.position_m.x_m, 0.0, frame.position_m.z_m},
                    .line = line.validation ? "" : line.id});
    if (!line.validation) lines.insert(line.id);
  }
  if (grid.empty()) {
    throw Error(
        fmt::format("{}: no station of the grid is captured yet; there is nothing to "
                    "export",
                    session->directory().string()));
  }
  const fs::path poses = session->directory() / "poses.csv";
  write_file_atomically(poses, frame_list_text(grid));
  std::string summary =
      fmt::format("{}: {} frames on {} lines", poses.string(), grid.size(), lines.size());
  if (!truth.empty()) {
    const fs::path views = session->directory() / "gt.csv";
    write_file_atomically(views, frame_list_text(truth));
    summary += fmt::format("; {}: {} ground-truth views", views.string(), truth.size());
  }
  return summary + left_out(contents.stations, verification);
}

}  // namespace raywalk::capture
