#include "capture/session/session_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <mutex>
#include <set>
#include <system_error>

#include "capture/session/frame_files.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/sha256.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// What is wrong with a frame; empty where nothing is.
std::string fault_of(const FrameRecord& frame, const fs::path& directory) {
  const fs::path file = directory / frame.file;
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (error) {
    return fmt::format("{} (station {}): {}", frame.file, frame.station, error.message());
  }
  if (bytes != static_cast<std::uintmax_t>(frame.bytes)) {
    return fmt::format("{} (station {}): {} bytes, {} were written", frame.file, frame.station,
                       bytes, frame.bytes);
  }
  try {
    const std::string content = read_file(file);
    if (sha256_hex(content) == frame.sha256) return "";
    return fmt::format("{} (station {}): changed since it was written (SHA-256 differs)",
                       frame.file, frame.station);
  } catch (const Error& unreadable) {
    return fmt::format("{} (station {}): {}", frame.file, frame.station, unreadable.what());
  }
}

void check_frames(const std::vector<FrameRecord>& frames, const fs::path& directory,
                  SessionVerification* verification) {
  Progress progress("verifying", static_cast<std::int64_t>(frames.size()), "frames");
  std::vector<std::string> faults(frames.size());
  parallel_for(0, static_cast<int>(frames.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto index = static_cast<std::size_t>(i);
      faults[index] = fault_of(frames[index], directory);
      progress.advance();
    }
  });
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ++verification->frames;
    verification->bytes += frames[i].bytes;
    if (!faults[i].empty()) verification->faults.push_back(std::move(faults[i]));
  }
}

void check_database(SqliteConnection* database, SessionVerification* verification) {
  const std::string integrity = database->text("PRAGMA integrity_check(1)");
  if (integrity != "ok") {
    verification->faults.push_back("session.db: " + one_line(integrity));
  }
  const std::int64_t dangling =
      database->integer("SELECT count(*) FROM pragma_foreign_key_check()");
  if (dangling > 0) {
    verification->faults.push_back(
        fmt::format("session.db: {} rows refer to missing rows", dangling));
  }
  const std::int64_t without = database->integer(
      "SELECT count(*) FROM attempt WHERE outcome = 'captured' AND NOT EXISTS "
      "(SELECT 1 FROM frame WHERE frame.attempt_id = attempt.id)");
  if (without > 0) {
    verification->faults.push_back(
        fmt::format("session.db: {} captured stations have no frame", without));
  }
}

}  // namespace

SessionVerification verify_session(SessionReader* session) {
  SessionVerification verification;
  check_database(&session->database(), &verification);
  // In this order, so that a frame stored by a run meanwhile is not taken for a leftover.
  const std::vector<std::string> files = list_frames(session->directory());
  const std::vector<FrameRecord> frames = session->frames();
  check_frames(frames, session->directory(), &verification);
  std::set<std::string> named;
  for (const FrameRecord& frame : frames) named.insert(frame.file);
  std::copy_if(files.begin(), files.end(), std::back_inserter(verification.leftover),
               [&](const std::string& file) { return !named.contains(file); });
  return verification;
}

std::string verification_text(const SessionVerification& verification) {
  std::string text;
  for (const std::string& fault : verification.faults) text += fault + "\n";
  for (const std::string& file : verification.leftover) {
    text += file + ": belongs to no captured station (left by a run or a shot that failed)\n";
  }
  return text +
         fmt::format("{} frames of {:.1f} MB checked, {} wrong; {} files belong to no station\n",
                     verification.frames, static_cast<double>(verification.bytes) / 1e6,
                     verification.faults.size(), verification.leftover.size());
}

void require_whole(const SessionVerification& verification, const SessionReader& session) {
  if (verification.is_whole()) return;
  throw Error(fmt::format("{}: {}; {} faults in all, restore what is named from a copy",
                          session.directory().string(), verification.faults.front(),
                          verification.faults.size()));
}

}  // namespace raywalk::capture
