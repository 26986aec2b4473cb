#include "capture/session/frame_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

constexpr char kFramesDirectory[] = "frames";
constexpr char kTemporaryExtension[] = ".partial";

[[noreturn]] void throw_store_error(const fs::path& file, const std::error_code& code) {
  if (code.value() == EEXIST) {
    throw Error(
        fmt::format("{} already exists and is not overwritten; move it elsewhere", file.string()));
  }
  if (code.value() == ENOSPC || code.value() == EDQUOT) {
    throw Error(fmt::format("cannot write {}: {}; free some space (nothing of this frame was kept)",
                            file.string(), code.message()));
  }
  throw Error(fmt::format("cannot write {}: {}; check the disk and its permissions", file.string(),
                          code.message()));
}

}  // namespace

FrameFiles::FrameFiles(const fs::path& session_directory, DiskLayer* disk)
    : session_directory_(session_directory),
      directory_(session_directory / kFramesDirectory),
      disk_(disk) {}

void FrameFiles::make_directory() {
  try {
    if (fs::create_directory(directory_)) disk_->sync_directory(session_directory_);
  } catch (const std::system_error& error) {
    throw Error(fmt::format("cannot create {}: {}", directory_.string(), error.code().message()));
  }
}

std::string FrameFiles::store(const std::string& name, std::span<const std::byte> bytes) {
  write_durably(directory_ / name, bytes);
  return fmt::format("{}/{}", kFramesDirectory, name);
}

void FrameFiles::write_durably(const fs::path& file, std::span<const std::byte> bytes) {
  const fs::path temporary = directory_ / ("." + file.filename().string() + kTemporaryExtension);
  const fs::path* made = nullptr;  // the file that exists so far
  try {
    const std::unique_ptr<DiskFile> output = disk_->create(temporary);
    made = &temporary;
    output->write(bytes);
    output->sync();
    output->close();
    disk_->rename_new(temporary, file);
    made = &file;
    disk_->sync_directory(directory_);
  } catch (const std::system_error& error) {
    try {
      if (made != nullptr) disk_->remove(*made);
    } catch (const std::system_error&) {
      // A disk that fails again leaves a temporary file, which the next run removes.
    }
    throw_store_error(file, error.code());
  }
}

void FrameFiles::remove_temporaries() {
  for (const std::string& file : list_frames(session_directory_)) {
    if (!is_temporary_frame(file)) continue;
    try {
      disk_->remove(session_directory_ / file);
    } catch (const std::system_error& error) {
      throw Error(fmt::format("cannot remove {}, left by an earlier run: {}",
                              (session_directory_ / file).string(), error.code().message()));
    }
  }
}

bool is_temporary_frame(const fs::path& file) {
  return file.filename().string().starts_with('.') && file.extension() == kTemporaryExtension;
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
