#include "core/files/file_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>

#include "core/base/error.h"
#include "core/base/interrupt.h"
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

constexpr auto kRetryEvery = std::chrono::milliseconds(20);
constexpr auto kWaitAtMost = std::chrono::seconds(10);

}  // namespace

FileLock::FileLock(const std::filesystem::path& file, const std::string& busy, Use use)
    : file_(file),
      busy_(directory_of(file).string() + ": " + busy),
      fd_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (fd_ < 0) throw_system_error("write", directory_of(file), errno);
  try {
    if (use == Use::kShared) {
      wait_to_share(true);
    } else if (!try_alone()) {
      throw Error(busy_);
    }
  } catch (...) {
    ::close(fd_);
    throw;
  }
}

FileLock::~FileLock() { ::close(fd_); }

bool FileLock::lock(int how) {
  const int error_number = ::flock(fd_, how | LOCK_NB) == 0 ? 0 : errno;
  if (error_number != 0 && error_number != EWOULDBLOCK) {
    throw_system_error("lock", file_, error_number);
  }
  return error_number == 0 && is_file_of_name(fd_, file_);
}

bool FileLock::try_alone() {
  if (!alone_) alone_ = lock(LOCK_EX);
  return alone_;
}

void FileLock::wait_to_share(bool may_be_alone) {
  const auto give_up = std::chrono::steady_clock::now() + kWaitAtMost;
  while (true) {
    if (may_be_alone && try_alone()) return;
    if (lock(LOCK_SH)) return;
    if (std::chrono::steady_clock::now() > give_up) throw Error(busy_);
    throw_if_interrupted();
    std::this_thread::sleep_for(kRetryEvery);
  }
}

void FileLock::share() {
  if (!alone_) return;
  alone_ = false;
  wait_to_share(false);
}

}  // namespace raywalk
