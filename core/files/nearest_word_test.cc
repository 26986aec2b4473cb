#include "core/files/nearest_word.h"

#include <gtest/gtest.h>

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

TEST(Suggestion, ListsValidWordsIfNoneIsNear) {
  EXPECT_EQ(suggestion("hybird", {"hybrid", "lfu"}), "; did you mean 'hybrid'?");
  EXPECT_EQ(suggestion("stereo", {"hybrid", "lfu"}), "; valid are hybrid, lfu");
}

}  // namespace
}  // namespace raywalk
