// The folder of a session that is being merged (merge_sessions.h), and its frames.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/files/file_lock.h"

namespace raywalk::capture {

struct MergedFrame {
  std::filesystem::path source{};  // in its session
  std::string file{};              // relative to every session's directory, "frames/x0_007.jpg"
  std::string sha256{};
};

class MergedFiles {
 public:
  // Creates `directory`, or goes on with one that a stopped merge left. Throws Error: it holds
  // anything else, another merge writes to it, or it cannot be written.
  explicit MergedFiles(std::filesystem::path directory);

  // Links or copies every frame that is not there yet and removes files of other merges; on the
  // disk when it returns. Throws Error (disk full; two frames of one name) and Interrupted.
  void take(const std::vector<MergedFrame>& frames) const;

 private:
  std::filesystem::path directory_;
  FileLock lock_;
};

}  // namespace raywalk::capture
