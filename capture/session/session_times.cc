#include "capture/session/session_times.h"

#include <fmt/chrono.h>

namespace raywalk::capture {

std::int64_t utc_us_from(WallTime time) {
  return std::chrono::floor<std::chrono::microseconds>(time.time_since_epoch()).count();
}

WallTime wall_time_from(std::int64_t utc_us) {
  return WallTime{
      std::chrono::duration_cast<WallTime::duration>(std::chrono::microseconds(utc_us))};
}

std::string utc_text(std::int64_t utc_us) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(wall_time_from(utc_us));
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(seconds));
}

}  // namespace raywalk::capture
