#include "core/base/escaped.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace raywalk {
namespace {

TEST(Escaped, KeepsTextOfAllScripts) {
  const std::string text = "Größe 90°, 部屋 \xF0\x9F\x93\xB7 'a' \\ \"b\"";
  EXPECT_EQ(escaped(text), text);
  EXPECT_EQ(escaped(""), "");
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

}  // namespace
}  // namespace raywalk
