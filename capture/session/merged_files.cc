#include "capture/session/merged_files.h"

#include <fmt/format.h>

#include <set>
#include <system_error>
#include <utility>

#include "capture/session/disk_layer.h"
#include "capture/session/frame_files.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// Only what a stopped merge may have left.
fs::path own_directory(fs::path directory) {
  const std::set<std::string> own = {"session.db", "session.db-wal", "session.db-shm",
                                     "session.lock", "frames"};
  std::error_code error;
  if (fs::exists(directory, error)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
      const std::string name = entry.path().filename().string();
      if (own.contains(name)) continue;
      throw Error(
          fmt::format("{}: holds {}, which no merge writes there; remove it or give "
                      "another --out",
                      directory.string(), excerpt(name)));
    }
  }
  make_directories(directory);
  return directory;
}

// Whether an earlier run put the frame there. A link is the same file; a copy is read.
bool is_there(const MergedFrame& frame, const fs::path& target) {
  std::error_code error;
  if (fs::equivalent(frame.source, target, error)) return true;
  return fs::exists(target, error) && sha256_of_file(target) == frame.sha256;
}

void take_frame(const MergedFrame& frame, const fs::path& target) {
  std::error_code error;
  fs::create_hard_link(frame.source, target, error);
  if (!error) return;
  AtomicFile copy(target);
  fs::copy_file(frame.source, copy.temporary_path(), error);
  if (error) {
    throw Error(fmt::format("cannot copy {} to {}: {}; the same command goes on from here",
                            frame.source.string(), target.string(), error.message()));
  }
  copy.commit();
}

}  // namespace

MergedFiles::MergedFiles(fs::path directory)
    : directory_(own_directory(std::move(directory))),
      lock_(directory_ / "session.lock", "another raywalk-capture merges sessions into it") {}

void MergedFiles::take(const std::vector<MergedFrame>& frames) const {
  FrameFiles(directory_, &system_disk()).make_directory();
  std::set<std::string> wanted;
  for (const MergedFrame& frame : frames) {
    if (wanted.insert(frame.file).second) continue;
    throw Error(
        fmt::format("{}: another of the sessions has a frame of this name; it is not one "
                    "that raywalk-capture wrote",
                    frame.source.string()));
  }
  for (const std::string& file : list_frames(directory_)) {
    if (!wanted.contains(file)) fs::remove(directory_ / file);
  }
  Progress progress("merging", static_cast<std::int64_t>(frames.size()), "frames");
  for (const MergedFrame& frame : frames) {
    throw_if_interrupted();
    const fs::path target = directory_ / frame.file;
    if (!is_there(frame, target)) {
      fs::remove(target);
      take_frame(frame, target);
    }
    progress.advance();
  }
  system_disk().sync_directory(directory_ / "frames");
}

}  // namespace raywalk::capture
