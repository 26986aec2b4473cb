#include "capture/slider/soft_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

TEST(SoftLimitsTest, BothEndsAreAllowedAndNothingBeyond) {
  const SoftLimits limits(10.0, 20.0);
  EXPECT_EQ(limits.require(10.0, "station a").mm(), 10.0);
  EXPECT_EQ(limits.require(20.0, "station b").mm(), 20.0);
  for (const double mm :
       {std::nextafter(10.0, 0.0), std::nextafter(20.0, 30.0), -1e300,
        std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
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
  EXPECT_THROW(SoftLimits(std::numeric_limits<double>::quiet_NaN(), 5.0), UsageError);
  EXPECT_THROW(SoftLimits(0.0, std::numeric_limits<double>::infinity()), UsageError);
}

}  // namespace
}  // namespace raywalk::capture
