// Soft limits, and times of moves.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "capture/slider/slider_state.h"
#include "capture/slider/soft_limits.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

TEST(SoftLimitsTest, BothEndsAreAllowedAndNothingBeyond) {
  const SoftLimits limits(10.0, 20.0);
  for (const double mm : {10.0, 20.0}) EXPECT_EQ(limits.require(mm, "station a").mm(), mm);
  for (const double mm :
       {std::nextafter(10.0, 0.0), std::nextafter(20.0, 30.0), -1e300, kInfinity, kNoNumber}) {
    EXPECT_THROW(limits.require(mm, "station c"), UsageError) << mm;
  }
}

TEST(SoftLimitsTest, RefusalNamesTheTarget) {
  try {
    SoftLimits(0.0, 100.0).require(100.5, "station x0_003");
    ADD_FAILURE() << "allowed";
  } catch (const UsageError& e) {
    EXPECT_STREQ(e.what(), "station x0_003: 100.500 mm is outside the soft limits, 0 to 100 mm");
  }
}

TEST(SoftLimitsTest, EmptyRangesAreRefused) {
  EXPECT_THROW(SoftLimits(5.0, 5.0), UsageError);
  EXPECT_THROW(SoftLimits(6.0, 5.0), UsageError);
  EXPECT_THROW(SoftLimits(kNoNumber, 5.0), UsageError);
  EXPECT_THROW(SoftLimits(0.0, kInfinity), UsageError);
}

TEST(MotionProfileTest, TimesOfATrapezoid) {
  const MotionProfile profile{100.0, 200.0};
  // Ramps of 0.5 s and 25 mm each, 50 mm at 100 mm/s between them.
  EXPECT_DOUBLE_EQ(profile.moving_ms(100.0), 1500.0);
  EXPECT_DOUBLE_EQ(profile.moving_ms(2.0), 200.0);  // 2 sqrt(d/a), without a cruise
  EXPECT_EQ(profile.moving_ms(0.0), 0.0);
  EXPECT_DOUBLE_EQ(profile.stopping_ms(), 500.0);
}

}  // namespace
}  // namespace raywalk::capture
