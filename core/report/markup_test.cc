#include "core/report/markup.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace raywalk {
namespace {

TEST(EscapeMarkup, EscapesSpecialCharacters) {
  EXPECT_EQ(escape_markup(R"(<a href="x">Tom & 'Jerry'</a>)"),
            "&lt;a href=&quot;x&quot;&gt;Tom &amp; &#39;Jerry&#39;&lt;/a&gt;");
}

TEST(EscapeMarkup, KeepsPlainTextAndUtf8) {
  const std::string text = "360\xC2\xB0 \xE2\x86\x92 \xF0\x9F\x93\xB7, line\nbreak\ttab";
  EXPECT_EQ(escape_markup(text), text);
  EXPECT_EQ(escape_markup(""), "");
}

TEST(EscapeMarkup, ReplacesBytesThatAreNotUtf8) {
  const std::string mark = "\xEF\xBF\xBD";
  EXPECT_EQ(escape_markup("a\xFFz"), "a" + mark + "z");
  EXPECT_EQ(escape_markup("a\xC3"), "a" + mark);                            // cut short
  EXPECT_EQ(escape_markup("\xC3("), mark + "(");                            // bad continuation
  EXPECT_EQ(escape_markup("\xC0\xBC"), mark + mark);                        // overlong '<'
  EXPECT_EQ(escape_markup("\xE0\x80\xBC"), mark + mark + mark);             // overlong '<'
  EXPECT_EQ(escape_markup("\xED\xA0\x80"), mark + mark + mark);             // surrogate
  EXPECT_EQ(escape_markup("\xF4\x90\x80\x80"), mark + mark + mark + mark);  // over U+10FFFF
}

TEST(EscapeMarkup, ReplacesControlCharacters) {
  EXPECT_EQ(escape_markup(std::string("a\0b\x1B", 4)),
            "a\xEF\xBF\xBD"
            "b\xEF\xBF\xBD");
}

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

}  // namespace
}  // namespace raywalk
