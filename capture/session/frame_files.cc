#include "capture/session/frame_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "core/base/error.h"

namespace raywalk::capture {

namespace fs = std::filesystem;

bool is_temporary_frame(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with('.') && name.find(".partial") != std::string::npos;
}

void remove_temporary_frames(const fs::path& session_directory) {
  for (const std::string& file : list_frames(session_directory)) {
    if (!is_temporary_frame(file)) continue;
    std::error_code error;
    fs::remove(session_directory / file, error);
    if (!error) continue;
    throw Error(fmt::format("cannot remove {}, left by an earlier run: {}",
                            (session_directory / file).string(), error.message()));
  }
}

std::vector<std::string> list_frames(const fs::path& session_directory) {
  const fs::path directory = session_directory / kFramesDirectory;
  std::vector<std::string> files;
  if (!fs::exists(directory)) return files;
  try {
    for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
      files.push_back(fmt::format("{}/{}", kFramesDirectory, entry.path().filename().string()));
    }
  } catch (const fs::filesystem_error& error) {
    throw Error(fmt::format("cannot read {}: {}", directory.string(), error.code().message()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace raywalk::capture
