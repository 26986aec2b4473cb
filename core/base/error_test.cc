#include "core/base/error.h"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

namespace raywalk {
namespace {

TEST(OneLine, FoldsLineBreaksAndTrims) {
  EXPECT_EQ(one_line("  OpenCV(4.6.0)\r\n\terror: (-215)  in 'f'\n"),
            "OpenCV(4.6.0) error: (-215) in 'f'");
}

TEST(OneLine, KeepsNoControlCharacterForTheTerminal) {
  EXPECT_EQ(one_line("a\x1b[31mred\x7f"), R"(a\u001b[31mred\u007f)");
}

TEST(Excerpt, ShortTextIsShownWhole) { EXPECT_EQ(excerpt("1,5"), "'1,5'"); }

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

}  // namespace
}  // namespace raywalk
