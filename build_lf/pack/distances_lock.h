// Held while a room's distances or gains, and so its manifest, change.
#pragma once

#include <filesystem>

#include "core/files/file_lock.h"

namespace raywalk::build_lf {

// The lock's file is removed with it.
class DistancesLock {
 public:
  // Throws Error if another process holds the lock.
  explicit DistancesLock(const std::filesystem::path& room)
      : file_(room / "distances.lock"),
        lock_(file_,
              "another raywalk-build-lf is changing this room's distances; wait for it to finish") {
  }
  ~DistancesLock() {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
  }
  DistancesLock(const DistancesLock&) = delete;
  DistancesLock& operator=(const DistancesLock&) = delete;

 private:
  std::filesystem::path file_;
  FileLock lock_;
};

}  // namespace raywalk::build_lf
