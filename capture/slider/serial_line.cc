#include "capture/slider/serial_line.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "capture/base/device_fault.h"

namespace raywalk::capture {
namespace {

[[noreturn]] void fail_port(const std::string& what) {
  throw DeviceFault(FaultKind::kNoContact, what);
}

[[noreturn]] void fail_in_use(const std::string& device) {
  fail_port(
      fmt::format("{} is in use by another program; end it (fuser {} names it)", device, device));
}

[[noreturn]] void fail_to_open(const std::string& device, int error) {
  switch (error) {
    case EBUSY:
      fail_in_use(device);
    case ENOENT:
    case ENXIO:
    case ENODEV:
      fail_port(
          fmt::format("{} does not exist; plug in the adapter and see /dev/serial/by-id", device));
    case EACCES:
      fail_port(fmt::format("no permission for {}; add the user to the group dialout", device));
    default:
      fail_port(
          fmt::format("cannot open {} ({}); check the adapter", device, std::strerror(error)));
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

timespec timespec_from(Duration duration) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(duration);
  return {static_cast<time_t>(seconds.count()), static_cast<long>((duration - seconds).count())};
}

// Waits until bytes can be read or the line is closed, at most for the time given. Signals do not
// end the wait.
bool has_input(int fd, Duration wait) {
  const SteadyTime end = std::chrono::steady_clock::now() + wait;
  pollfd line{fd, POLLIN, 0};
  for (;;) {
    const Duration left =
        std::max(Duration::zero(), Duration(end - std::chrono::steady_clock::now()));
    const timespec timeout = timespec_from(left);
    const int ready = ppoll(&line, 1, &timeout, nullptr);
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

// Drops the received bytes. False if the line is closed.
bool drop_input(int fd) {
  std::array<std::uint8_t, 512> dropped{};
  const ssize_t got = read(fd, dropped.data(), dropped.size());
  return got > 0 || (got < 0 && (errno == EAGAIN || errno == EINTR));
}

}  // namespace

PortLock::PortLock(const std::string& device)
    // O_NONBLOCK: without it, open waits for a modem's carrier.
    : fd_(open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (fd_ < 0) fail_to_open(device, errno);
  if (isatty(fd_) == 0) {
    close(fd_);
    fail_port(fmt::format("{} is not a serial port; correct slider.device", device));
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

LineState wait_until_quiet(int fd, Duration quiet, Duration patience) {
  const SteadyTime end = std::chrono::steady_clock::now() + patience;
  while (has_input(fd, quiet)) {
    if (!drop_input(fd)) return LineState::kGone;
    if (std::chrono::steady_clock::now() >= end) return LineState::kNeverQuiet;
  }
  return LineState::kQuiet;
}

Duration frame_gap(int baud) {
  constexpr double kCharacters = 3.5;
  constexpr double kBitsOfCharacter = 11.0;
  constexpr double kGapAbove19200_ms = 1.75;
  if (baud > 19200) return duration_from_ms(kGapAbove19200_ms);
  return duration_from_ms(kCharacters * kBitsOfCharacter * 1000.0 / baud);
}

}  // namespace raywalk::capture
