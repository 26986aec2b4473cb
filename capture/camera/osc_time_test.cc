#include "capture/camera/osc_time.h"

#include <gtest/gtest.h>

namespace raywalk::capture {
namespace {

using std::chrono::sys_days;
using namespace std::chrono_literals;

TEST(OscTime, DateTimeZoneIsTakenToUtc) {
  const WallTime expected = sys_days(2014y / 5 / 17) + 17h + 4min + 29s;
  EXPECT_EQ(time_from_date_time_zone("2014:05:18 01:04:29+08:00"), expected);
  EXPECT_EQ(time_from_date_time_zone("2014:05:17 11:34:29-05:30"), expected);
  EXPECT_EQ(time_from_date_time_zone("2014:05:17 17:04:29+00:00"), expected);
}

TEST(OscTime, OtherTextsAreNone) {
  for (const char* text :
       {"", "0000:00:00 00:00:00+00:00", "2014:05:18 01:04:29", "2014:02:30 01:04:29+08:00",
        "2014:05:18 01:04:29+8:00", "2014:05:18 01:04:29 08:00", "2014-05-18T01:04:29+08:00",
        "2014:05:18 01:04:29+08:00 and more", "yesterday"}) {
    EXPECT_EQ(time_from_date_time_zone(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace raywalk::capture
