#include "core/files/number.h"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <limits>
#include <random>

namespace raywalk {
namespace {

TEST(ParseFiniteNumber, RoundTripsDoublesOfAnySize) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-300.0, 300.0);
  for (int i = 0; i < 2000; ++i) {
    const double value = std::pow(10.0, exponent(random)) * (i % 2 == 0 ? 1.0 : -1.0);
    EXPECT_EQ(parse_finite_number(fmt::format("{}", value)), value);
  }
}

TEST(ParseFiniteNumber, RequiresTheWholeText) {
  EXPECT_EQ(parse_finite_number("+1.5"), 1.5);
  for (const char* bad : {"", " 1", "1 ", "1,5", "0x1p3", "+", "-", "+-1", "++1", "nan", "inf",
                          "1e400", "1e", "1_0", "1f"}) {
    EXPECT_FALSE(parse_finite_number(bad)) << bad;
  }
}

TEST(ParseWholeNumber, CoversExactlyTheRangeOfInt) {
  EXPECT_EQ(parse_whole_number("2147483647"), std::numeric_limits<int>::max());
  EXPECT_EQ(parse_whole_number("-2147483648"), std::numeric_limits<int>::min());
  for (const char* bad : {"2147483648", "-2147483649", "1.0", "1e3", "", "x", "0x10"}) {
    EXPECT_FALSE(parse_whole_number(bad)) << bad;
  }
}

TEST(ParseWholeOrHexadecimalNumber, TakesBothAndNothingElse) {
  EXPECT_EQ(parse_whole_or_hexadecimal_number("-12"), -12);
  EXPECT_EQ(parse_whole_or_hexadecimal_number("0x6200"), 0x6200);
  EXPECT_EQ(parse_whole_or_hexadecimal_number("0X7fffFFFF"), std::numeric_limits<int>::max());
  for (const char* bad : {"0x", "0x80000000", "0x-1", "0x+1", "-0x1", "0x0x1", "x1", "0x1g"}) {
    EXPECT_FALSE(parse_whole_or_hexadecimal_number(bad)) << bad;
  }
}

}  // namespace
}  // namespace raywalk
