#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"

namespace raywalk {
namespace {

TEST(OneLine, FoldsLineBreaksAndTrims) {
  EXPECT_EQ(one_line("  OpenCV(4.6.0)\r\n\terror: (-215)  in 'f'\n"),
            "OpenCV(4.6.0) error: (-215) in 'f'");
}

TEST(OneLine, KeepsNoControlCharacterForTheTerminal) {
  EXPECT_EQ(one_line("a\x1b[31mred\x7f"), R"(a\u001b[31mred\u007f)");
}

TEST(Excerpt, ShowsWhatTheTextHolds) { EXPECT_EQ(excerpt("a  b\n"), R"('a  b\n')"); }

TEST(Excerpt, LongTextIsCut) {
  EXPECT_EQ(excerpt(std::string(1000, 'x')), fmt::format("'{}...'", std::string(60, 'x')));
}

TEST(Excerpt, CutsBetweenCharacters) {
  const std::string umlauts = "x" + std::string("öööööööööööööööööööööööööööööööööööööööö");
  const std::string shown = excerpt(umlauts);
  // 1 byte and 2-byte characters: 59 is the longest whole number of them below 60.
  EXPECT_EQ(shown, fmt::format("'{}...'", umlauts.substr(0, 59)));
}

TEST(Escaped, KeepsTextOfAllScripts) {
  const std::string text = "Größe 90°, 部屋 \xF0\x9F\x93\xB7 'a' \\ \"b\"";
  EXPECT_EQ(escaped(text), text);
  EXPECT_EQ(escaped(""), "");
}

TEST(ShellWord, IsTakenByAShellAsTheName) {
  EXPECT_EQ(shell_word("hall/poses-2.csv"), "hall/poses-2.csv");
  EXPECT_EQ(shell_word("my hall"), "'my hall'");
  EXPECT_EQ(shell_word("a'b$c"), R"('a'\''b$c')");
  EXPECT_EQ(shell_word("Größe"), "'Größe'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(Escaped, ShowsControlCharacters) {
  EXPECT_EQ(escaped("a\nb\tc\r"), R"(a\nb\tc\r)");
  EXPECT_EQ(escaped("\x1b[31mred\x7f"), R"(\u001b[31mred\u007f)");
  EXPECT_EQ(escaped(std::string_view("a\0b", 3)), R"(a\u0000b)");
  EXPECT_EQ(escaped("\xC2\x9B[2J"), R"(\u009b[2J)");  // U+009B, as ESC [
}

TEST(Escaped, ShowsWhatBreaksLinesOrTurnsText) {
  EXPECT_EQ(escaped("a\u2028b"), R"(a\u2028b)");
  EXPECT_EQ(escaped("a\u202Egpj.exe"), R"(a\u202egpj.exe)");
}

TEST(Escaped, ShowsBytesThatAreNotUtf8) {
  EXPECT_EQ(escaped("a\xFFz"), R"(a\xffz)");
  EXPECT_EQ(escaped("a\xC3"), R"(a\xc3)");                        // cut short
  EXPECT_EQ(escaped("\xC3("), R"(\xc3()");                        // bad continuation
  EXPECT_EQ(escaped("\xC0\xBC"), R"(\xc0\xbc)");                  // overlong '<'
  EXPECT_EQ(escaped("\xE0\x80\xBC"), R"(\xe0\x80\xbc)");          // overlong '<'
  EXPECT_EQ(escaped("\xED\xA0\x80"), R"(\xed\xa0\x80)");          // surrogate
  EXPECT_EQ(escaped("\xF4\x90\x80\x80"), R"(\xf4\x90\x80\x80)");  // over U+10FFFF
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

TEST(Counted, HasAPluralUnlessThereIsOne) {
  EXPECT_EQ(counted(0, "line"), "0 lines");
  EXPECT_EQ(counted(1, "line"), "1 line");
  EXPECT_EQ(counted(2, "line"), "2 lines");
}

}  // namespace
}  // namespace raywalk
