#include "core/files/words.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace raywalk {
namespace {

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

const std::vector<std::string> kColumns = {"file", "x", "y", "z", "yaw", "pitch", "roll"};

TEST(NearestWord, FindsTypingErrorsAndTheClosestFirst) {
  EXPECT_EQ(nearest_word("ptich", kColumns), "pitch");
  EXPECT_EQ(nearest_word("rol", kColumns), "roll");
  EXPECT_EQ(nearest_word("files", kColumns), "file");
  EXPECT_EQ(nearest_word("overlap_dge", {"k_deg", "overlap_deg"}), "overlap_deg");
  EXPECT_EQ(nearest_word("yax", {"yawn", "yaw"}), "yaw");
}

TEST(NearestWord, DifferentWordsDoNotMatch) {
  EXPECT_FALSE(nearest_word("temperature", kColumns));
  EXPECT_FALSE(nearest_word("q", kColumns)) << "a letter resembles no other letter";
  EXPECT_FALSE(nearest_word("", kColumns));
  EXPECT_FALSE(nearest_word("yaw", {}));
}

TEST(NearestWord, AKeyMayStandInTheWrongGroup) {
  const std::vector<std::string> keys = {"grid.k_deg", "slider.motion.speed_mm_s", "run.shots"};
  EXPECT_EQ(nearest_word("speed_mm_s", keys), "slider.motion.speed_mm_s");
  EXPECT_EQ(nearest_word("camera.shots", keys), "run.shots");
  EXPECT_EQ(nearest_word("motion.sped_mm_s", keys), "slider.motion.speed_mm_s");
  EXPECT_FALSE(nearest_word("grid.temperature", keys));
}

TEST(Suggestion, NamesTheNearestOfManyFirst) {
  std::vector<std::string> keys;
  for (int i = 0; i < 70; ++i) keys.push_back(fmt::format("group.other_{}", i));
  keys.emplace_back("slider.motion.acceleration_mm_s2");
  EXPECT_THAT(suggestion("slider.accel", keys),
              testing::MatchesRegex("; the nearest valid ones are "
                                    "'slider.motion.acceleration_mm_s2', '[a-z_.0-9]+', "
                                    "'[a-z_.0-9]+'"));
  EXPECT_LT(suggestion(std::string(1 << 20, 'x'), keys).size(), 200U);
}

TEST(Suggestion, ListsValidWordsIfNoneIsNear) {
  EXPECT_EQ(suggestion("hybird", {"hybrid", "lfu"}), "; did you mean 'hybrid'?");
  EXPECT_EQ(suggestion("stereo", {"hybrid", "lfu"}), "; valid are hybrid, lfu");
}

}  // namespace
}  // namespace raywalk
