// A lock on a file (flock), which keeps two processes from writing the same output. It
// is held through an open descriptor, so the system releases it when the process ends or crashes.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk {

enum class LockKind {
  kAlone,
  kShared,  // with all others that share it
};

class FileLock {
 public:
  // Creates the file if it is missing and locks it. Throws Error: "cannot write <directory>: ..."
  // if it cannot be created, "<directory>: <busy>" if another process holds the lock, and one of
  // the two alone, or has just removed the file, "cannot lock <file>: ..." if the file system does
  // not support locks.
  FileLock(const std::filesystem::path& file, const std::string& busy,
           LockKind kind = LockKind::kAlone);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int fd_ = -1;
};

}  // namespace raywalk
