// The pictures of a session as files that appear complete, survive power loss and are never
// overwritten.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "capture/session/disk_layer.h"

namespace raywalk::capture {

// The directory frames/ of a session. A file is written under a temporary name (".<name>.partial"),
// synced, renamed without replacing, and its directory synced.
class FrameFiles {
 public:
  // Creates no directory. `disk` must outlive it.
  FrameFiles(const std::filesystem::path& session_directory, DiskLayer* disk);

  const std::filesystem::path& directory() const { return directory_; }
  // Creates the directory if it is missing, safe against power loss. Throws Error.
  void make_directory();
  // Stores a file under a plain name and returns its path relative to the session, "frames/<name>",
  // once it is on the disk. Throws Error naming it (disk full, name exists) and removes what it
  // wrote.
  std::string store(const std::string& name, std::span<const std::byte> bytes);
  // Removes the temporary files of a killed run.
  void remove_temporaries();

 private:
  void write_durably(const std::filesystem::path& file, std::span<const std::byte> bytes);

  std::filesystem::path session_directory_;
  std::filesystem::path directory_;
  DiskLayer* disk_;
};

// Whether a file in frames/ has a temporary name.
bool is_temporary_frame(const std::filesystem::path& file);

// Names of all files in frames/ of a session, relative to the session, sorted, with temporary ones.
// Empty if the directory is missing. Throws Error if it cannot be read.
std::vector<std::string> list_frames(const std::filesystem::path& session_directory);

}  // namespace raywalk::capture
