#include "capture/slider/port_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "capture/base/device_fault.h"

namespace raywalk::capture {
namespace {

[[noreturn]] void fail(const std::string& what) { throw DeviceFault(FaultKind::kNoContact, what); }

[[noreturn]] void fail_in_use(const std::string& device) {
  fail(fmt::format("{} is in use by another program; end it (fuser {} names it)", device, device));
}

[[noreturn]] void fail_to_open(const std::string& device, int error) {
  switch (error) {
    case EBUSY:
      fail_in_use(device);
    case ENOENT:
    case ENXIO:
    case ENODEV:
      fail(fmt::format("{} does not exist; plug in the adapter and see /dev/serial/by-id", device));
    case EACCES:
      fail(fmt::format("no permission for {}; add the user to the group dialout", device));
    default:
      fail(fmt::format("cannot open {} ({}); check the adapter", device, std::strerror(error)));
  }
}

bool is_pseudo_terminal(int fd) {
  // Device numbers of the Linux kernel (Documentation/admin-guide/devices.txt).
  constexpr unsigned kFirstMajor = 136;
  constexpr unsigned kLastMajor = 143;
  struct stat status = {};
  if (fstat(fd, &status) != 0) return false;
  return major(status.st_rdev) >= kFirstMajor && major(status.st_rdev) <= kLastMajor;
}

}  // namespace

PortLock::PortLock(const std::string& device)
    // O_NONBLOCK: without it, open waits for a modem's carrier.
    : fd_(open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (fd_ < 0) fail_to_open(device, errno);
  if (isatty(fd_) == 0) {
    close(fd_);
    fail(fmt::format("{} is not a serial port; correct slider.device", device));
  }
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    close(fd_);
    fail_in_use(device);
  }
}

PortLock::~PortLock() { close(fd_); }

// A serial port loses the flag when the last program closes it. A pseudo-terminal keeps it while
// its other side is open, so a killed program would lock out its successor; there flock must
// suffice.
void PortLock::refuse_others() {
  if (!is_pseudo_terminal(fd_)) ioctl(fd_, TIOCEXCL);
}

}  // namespace raywalk::capture
