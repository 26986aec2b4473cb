#include "core/judge/trade/timing_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>

#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk {
namespace {

constexpr mode_t kForEveryone = 0666;

[[noreturn]] void fail(const char* what, const std::filesystem::path& file) {
  throw Error(fmt::format("cannot {} {}: {}; make it readable, or remove it while no trade runs",
                          what, file.string(), std::generic_category().message(errno)));
}

// An existing file is opened without O_CREAT: Linux refuses O_CREAT for another user's file in a
// sticky directory such as /tmp (fs.protected_regular). Reading is enough to lock it.
int open_lock_file(const std::filesystem::path& file) {
  constexpr int kFlags = O_CLOEXEC | O_NOFOLLOW;
  constexpr int kTries = 3;  // another process may make or remove the file in between
  for (int i = 0; i < kTries; ++i) {
    for (const int access : {O_RDWR, O_RDONLY}) {
      const int fd = ::open(file.c_str(), access | kFlags);
      if (fd >= 0) return fd;
    }
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | kFlags, kForEveryone);
    if (fd < 0) continue;
    ::fchmod(fd, kForEveryone);  // whatever the umask
    return fd;
  }
  fail("open", file);
}

std::string holder_in(int fd) {
  std::array<char, 512> text{};
  const ssize_t count = ::pread(fd, text.data(), text.size(), 0);
  return count > 0 ? one_line({text.data(), static_cast<std::size_t>(count)}) : "another process";
}

// Another user's file may be read-only here; then an earlier holder stays in it.
void write_holder(int fd, const std::string& holder) {
  if (::ftruncate(fd, 0) == 0) {
    [[maybe_unused]] const ssize_t written = ::pwrite(fd, holder.data(), holder.size(), 0);
  }
}

}  // namespace

std::filesystem::path machine_timing_lock() { return "/tmp/raywalk-timing.lock"; }

void TimingLock::a_moment() { std::this_thread::sleep_for(std::chrono::milliseconds(100)); }

TimingLock::TimingLock(const std::filesystem::path& file, const std::string& work,
                       const std::function<void()>& pause)
    : fd_(open_lock_file(file)) {
  bool told = false;
  while (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) {
      ::close(fd_);
      fail("lock", file);
    }
    if (!told) {
      spdlog::warn(
          "{} is timing views on this machine; waiting for it to end, as the two would "
          "disturb each other (Ctrl-C stops waiting)",
          holder_in(fd_));
      told = true;
    }
    try {
      throw_if_interrupted();
      pause();
    } catch (...) {
      ::close(fd_);
      throw;
    }
  }
  write_holder(fd_, fmt::format("process {} ({})", ::getpid(), work));
}

TimingLock::~TimingLock() { ::close(fd_); }

}  // namespace raywalk
