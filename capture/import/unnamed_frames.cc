#include "capture/import/unnamed_frames.h"

#include <algorithm>
#include <set>

#include "capture/session/frame_files.h"
#include "core/files/atomic_output.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// Frames are named after their station: "x0_007.jpg", "x0_007_e1_front.jpg".
bool is_of_station(const fs::path& file, const std::string& station) {
  const std::string name = file.filename().string();
  return name.starts_with(station + ".") || name.starts_with(station + "_");
}

}  // namespace

UnnamedFrames::UnnamedFrames(SessionReader* reader) : session_directory_(reader->directory()) {
  std::set<std::string> named;
  const SessionContents contents = reader->contents();
  for (const SessionFrame& frame : contents.frames) named.insert(frame.file);
  files_ = list_frames(session_directory_);
  std::erase_if(files_, [&](const std::string& file) {
    const fs::file_status status = fs::symlink_status(session_directory_ / file);
    return named.contains(file) || is_temporary_frame(file) || !fs::is_regular_file(status);
  });
}

std::optional<std::string> UnnamedFrames::find(const std::string& station,
                                               const std::string& bytes) const {
  for (const std::string& file : files_) {
    const fs::path path = session_directory_ / file;
    if (!is_of_station(path, station) || read_file(path) != bytes) continue;
    // The file was synced before it was renamed; its directory may not have been.
    sync_directory(path.parent_path());
    return file;
  }
  return std::nullopt;
}

}  // namespace raywalk::capture
