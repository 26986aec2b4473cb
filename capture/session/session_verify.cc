#include "capture/session/session_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <set>
#include <utility>

#include "capture/session/frame_files.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// What is wrong with a frame; empty where nothing is.
std::string fault_of(const SessionContents& contents, const SessionFrame& frame) {
  std::string fault = file_fault(contents, frame);
  if (!fault.empty()) return fault;
  const std::string place =
      fmt::format("{} (station {})", frame.file, contents.station_of(frame).name);
  try {
    const std::string content = read_file(contents.directory / frame.file);
    if (sha256_hex(content) == frame.sha256) return "";
    return place + ": changed since it was written (SHA-256 differs)";
  } catch (const Error& unreadable) {
    return place + ": " + unreadable.what();
  }
}

void check_frames(const SessionContents& contents, SessionVerification* verification) {
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
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ++verification->frames;
    verification->bytes += frames[i].bytes;
    if (faults[i].empty()) continue;
    verification->faults.push_back({contents.station_of(frames[i]).name, std::move(faults[i])});
  }
}

}  // namespace

SessionVerification verify_session(SessionReader* session) {
  SessionVerification verification;
  // In this order, so that a frame stored by a run meanwhile is not taken for a leftover.
  const std::vector<std::string> files = list_frames(session->directory());
  const SessionContents contents = session->contents();
  verification.faults = incomplete_stations(contents);
  check_frames(contents, &verification);
  std::set<std::string> named;
  for (const SessionFrame& frame : contents.frames) named.insert(frame.file);
  std::copy_if(files.begin(), files.end(), std::back_inserter(verification.leftover),
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

}  // namespace raywalk::capture
