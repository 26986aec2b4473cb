#include "core/base/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace raywalk {
namespace {

TEST(FixedNumber, HasAllItsDecimals) {
  EXPECT_EQ(fixed_number(2.0, 2), "2.00");
  EXPECT_EQ(fixed_number(-3.14159, 1), "-3.1");
  EXPECT_EQ(fixed_number(100.0, 0), "100");
  EXPECT_EQ(fixed_number(-0.0004, 3), "0.000");
  EXPECT_EQ(fixed_number(-0.0, 0), "0");
}

TEST(NumberOrDash, HasADashForWhatIsNotFinite) {
  EXPECT_EQ(number_or_dash(2.0, 2), "2.00");
  EXPECT_EQ(number_or_dash(std::nan(""), 2), "–");
  EXPECT_EQ(number_or_dash(-std::numeric_limits<double>::infinity(), 2), "–");
}

TEST(PlainNumber, HasNoTrailingZeros) {
  EXPECT_EQ(plain_number(2.0, 3), "2");
  EXPECT_EQ(plain_number(0.25, 3), "0.25");
  EXPECT_EQ(plain_number(-3.14159, 1), "-3.1");
  EXPECT_EQ(plain_number(100.0, 0), "100");
  EXPECT_EQ(plain_number(0.0004, 3), "0");
  EXPECT_EQ(plain_number(-0.0004, 3), "0");
}

TEST(PlainNumber, PrintsNanAndInfinity) {
  EXPECT_EQ(plain_number(std::nan(""), 2), "nan");
  EXPECT_EQ(plain_number(std::numeric_limits<double>::infinity(), 2), "inf");
  EXPECT_EQ(plain_number(-std::numeric_limits<double>::infinity(), 2), "-inf");
  EXPECT_EQ(plain_number(std::numeric_limits<double>::max(), 2).size(), 309U);
}

TEST(Counted, HasAPluralUnlessThereIsOne) {
  EXPECT_EQ(counted(0, "line"), "0 lines");
  EXPECT_EQ(counted(1, "line"), "1 line");
  EXPECT_EQ(counted(2, "line"), "2 lines");
}

}  // namespace
}  // namespace raywalk
