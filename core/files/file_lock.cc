#include "core/files/file_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

[[noreturn]] void throw_system_error(const char* what, const std::filesystem::path& path,
                                     int error_number) {
  throw Error(fmt::format("cannot {} {}: {}", what, path.string(),
                          std::generic_category().message(error_number)));
}

// Whether the path still names the open file: a process that has just finished may have renamed or
// removed the directory, and the lock is then on a file that no other process can find.
bool is_file_of_name(int fd, const std::filesystem::path& file) {
  struct stat held = {}, named = {};
  return ::fstat(fd, &held) == 0 && ::stat(file.c_str(), &named) == 0 &&
         held.st_dev == named.st_dev && held.st_ino == named.st_ino;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& file, const std::string& busy, LockKind kind)
    : fd_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (fd_ < 0) throw_system_error("write", directory_of(file), errno);
  const int operation = kind == LockKind::kAlone ? LOCK_EX : LOCK_SH;
  const int error_number = ::flock(fd_, operation | LOCK_NB) == 0 ? 0 : errno;
  if (error_number == 0 && is_file_of_name(fd_, file)) return;
  ::close(fd_);
  if (error_number != 0 && error_number != EWOULDBLOCK) {
    throw_system_error("lock", file, error_number);
  }
  throw Error(directory_of(file).string() + ": " + busy);
}

FileLock::~FileLock() { ::close(fd_); }

}  // namespace raywalk
