// Conversion of the times of session.db: whole microseconds since 1970-01-01 00:00 UTC.
#pragma once

#include <cstdint>
#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

std::int64_t utc_us_from(WallTime time);
WallTime wall_time_from(std::int64_t utc_us);

// "2026-01-31 13:05:09 UTC".
std::string utc_text(std::int64_t utc_us);

}  // namespace raywalk::capture
