// Parsing the times that a camera on the network reports.
#pragma once

#include <optional>
#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

// The option dateTimeZone of the Open Spherical Camera API, "2014:05:18 01:04:29+08:00", in whole
// seconds; none for any other text, also without a zone.
std::optional<WallTime> time_from_date_time_zone(const std::string& text);

}  // namespace raywalk::capture
