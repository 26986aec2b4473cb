#include "core/files/file_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/base/error.h"

namespace raywalk {

FileLock::FileLock(const std::filesystem::path& file, const std::string& busy)
    : fd_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  const std::string directory = file.parent_path().string();
  if (fd_ < 0) {
    throw Error(
        fmt::format("cannot write {}: {}", directory, std::generic_category().message(errno)));
  }
  const bool locked = ::flock(fd_, LOCK_EX | LOCK_NB) == 0;
  struct stat held {
  }, named{};
  // A process that just finished has renamed or removed the directory: the lock is then of a file
  // that is no longer there under this name.
  const bool current = locked && ::fstat(fd_, &held) == 0 && ::stat(file.c_str(), &named) == 0 &&
                       held.st_ino == named.st_ino;
  if (!current) {
    ::close(fd_);
    throw Error(directory + ": " + busy);
  }
}

FileLock::~FileLock() { ::close(fd_); }

}  // namespace raywalk
