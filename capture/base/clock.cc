#include "capture/base/clock.h"

#include <ctime>

namespace raywalk::capture {

WallTime wall_time_of(const Clock& clock, SteadyTime time) {
  return clock.wall_now() - std::chrono::duration_cast<WallTime::duration>(clock.now() - time);
}

SteadyTime SystemClock::now() const { return std::chrono::steady_clock::now(); }

WallTime SystemClock::wall_now() const { return std::chrono::system_clock::now(); }

void SystemClock::sleep(Duration duration) {
  if (duration <= Duration::zero()) return;
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(duration);
  const timespec wait{seconds.count(), (duration - seconds).count()};
  // Unlike std::this_thread::sleep_for, nanosleep is not resumed after a signal.
  nanosleep(&wait, nullptr);
}

}  // namespace raywalk::capture
