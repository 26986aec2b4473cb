#include "capture/slider/quiet_line.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>

namespace raywalk::capture {
namespace {

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
