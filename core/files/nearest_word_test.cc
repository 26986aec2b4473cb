#include "core/files/nearest_word.h"

#include <gmock/gmock.h>

namespace raywalk {
namespace {

const std::vector<std::string> kColumns = {"file", "x", "y", "z", "yaw", "pitch", "roll"};

TEST(NearestWord, FindsTypingErrors) {
  EXPECT_EQ(nearest_word("ptich", kColumns), "pitch");
  EXPECT_EQ(nearest_word("rol", kColumns), "roll");
  EXPECT_EQ(nearest_word("files", kColumns), "file");
  EXPECT_EQ(nearest_word("overlap_dge", {"k_deg", "overlap_deg"}), "overlap_deg");
}

TEST(NearestWord, PrefersTheClosest) { EXPECT_EQ(nearest_word("yax", {"yawn", "yaw"}), "yaw"); }

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
  for (int i = 0; i < 70; ++i) keys.push_back("group.other_" + std::to_string(i));
  keys.push_back("slider.motion.acceleration_mm_s2");
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
