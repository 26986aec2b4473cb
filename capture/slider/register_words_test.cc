#include "capture/slider/register_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using ::testing::ElementsAre;

double log_uniform(double low, double high, std::mt19937_64* random) {
  return std::exp(std::uniform_real_distribution(std::log(low), std::log(high))(*random));
}

RegisterMap map_of(double steps_per_mm, std::vector<BlockWord> move) {
  RegisterMap map;
  map.name = "test";
  map.steps_per_mm = steps_per_mm;
  map.acceleration_per_mm_s2 = 1.0;
  map.move = {0, std::move(move)};
  return map;
}

SafePosition position(double mm) { return SoftLimits(-1e9, 1e9).require(mm, "test"); }

TEST(RegisterWordsTest, PositionsSurviveTheRegistersToHalfAStep) {
  std::mt19937_64 random(7);
  RegisterMap map = map_of(1.0, {{WordMeaning::kPositionHigh}, {WordMeaning::kPositionLow}});
  for (int i = 0; i < 20000; ++i) {
    map.steps_per_mm = log_uniform(1e-3, 1e7, &random);
    const double sign = random() % 2 == 0 ? 1.0 : -1.0;
    const double steps = log_uniform(1e-3, 2147483646.0, &random);
    const double mm = sign * std::min(steps / map.steps_per_mm, 1e9);
    const auto words = words_of_move(map, position(mm), MotionProfile{});
    map.low_word_first = false;
    EXPECT_NEAR(mm_from_steps(map, steps_from_words(map, words[0], words[1])), mm,
                0.5 / map.steps_per_mm * (1.0 + 1e-6));
    map.low_word_first = true;
    EXPECT_EQ(steps_from_words(map, words[1], words[0]), steps_from_mm(map, mm));
  }
}

TEST(RegisterWordsTest, TargetsBeyond32BitsAreRefused) {
  const RegisterMap map = map_of(1e6, {{WordMeaning::kPositionHigh}, {WordMeaning::kPositionLow}});
  EXPECT_EQ(steps_from_mm(map, 2147.483647), 2147483647);
  EXPECT_EQ(steps_from_mm(map, -2147.483648), -2147483647 - 1);
  EXPECT_THROW(steps_from_mm(map, 2147.4836475), UsageError);
  EXPECT_THROW(steps_from_mm(map, -2147.4836486), UsageError);
  EXPECT_THROW(words_of_move(map, position(1e8), MotionProfile{}), UsageError);
}

// The example of the CS2RS manual: 10000 steps at 200 turns per minute.
TEST(RegisterWordsTest, LeadshineBlockMatchesItsManual) {
  RegisterMap map = map_of(250.0, {{WordMeaning::kConstant, 1},
                                   {WordMeaning::kPositionHigh},
                                   {WordMeaning::kPositionLow},
                                   {WordMeaning::kSpeed},
                                   {WordMeaning::kAcceleration},
                                   {WordMeaning::kDeceleration},
                                   {WordMeaning::kConstant, 0},
                                   {WordMeaning::kConstant, 0x10}});
  map.speed_per_mm_s = 1.5;
  map.acceleration_per_mm_s2 = 0.0;
  map.acceleration_time_to_mm_s = 2000.0 / 3.0;
  const MotionProfile profile{400.0 / 3.0, 200.0 / 3.0};
  EXPECT_THAT(words_of_move(map, position(40.0), profile),
              ElementsAre(1, 0, 10000, 200, 10000, 10000, 0, 0x10));
}

TEST(RegisterWordsTest, WideSpeedsTakeTwoWords) {
  RegisterMap map = map_of(1.0, {{WordMeaning::kSpeedHigh}, {WordMeaning::kSpeedLow}});
  map.speed_per_mm_s = 1000.0;
  EXPECT_THAT(words_of_move(map, position(0.0), {100.0, 1.0}), ElementsAre(1, 34464));
}

TEST(RegisterWordsTest, SpeedsThatDoNotFitAreRefusedAndNotRoundedIntoRange) {
  RegisterMap map = map_of(1.0, {{WordMeaning::kSpeed}, {WordMeaning::kAcceleration}});
  EXPECT_THAT(words_of_move(map, position(0.0), {65535.0, 65535.0}), ElementsAre(65535, 65535));
  EXPECT_THROW(words_of_move(map, position(0.0), {65536.0, 1.0}), UsageError);
  EXPECT_THROW(words_of_move(map, position(0.0), {0.4, 1.0}), UsageError);
  EXPECT_THROW(words_of_move(map, position(0.0), {1.0, 0.4}), UsageError);
  EXPECT_THROW(words_of_move(map, position(0.0), {1.0, 65536.0}), UsageError);
}

TEST(RegisterWordsTest, FlagsFollowTheirBitAndItsSense) {
  EXPECT_EQ(flag_of(0x8000, std::nullopt), std::nullopt);
  EXPECT_EQ(flag_of(0x8000, StatusBit{15, false}), true);
  EXPECT_EQ(flag_of(0x7fff, StatusBit{15, false}), false);
  EXPECT_EQ(flag_of(0x0001, StatusBit{0, true}), false);
  EXPECT_EQ(flag_of(0x0000, StatusBit{0, true}), true);
}

}  // namespace
}  // namespace raywalk::capture
