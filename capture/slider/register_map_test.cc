#include "capture/slider/register_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/shipped_configs.h"
#include "core/files/test_directory.h"
#include "core/files/test_yaml_keys.h"

namespace raywalk::capture {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::filesystem::path shipped(const std::string& name) {
  return std::filesystem::path(RAYWALK_CONFIGS "/sliders") / name;
}

// A minimal map.
const char* const kMinimal =
    "name: small\nsteps_per_mm: 80\nposition_address: 10\nstatus_address: 12\nspeed_per_mm_s: 2\n"
    "acceleration_per_mm_s2: 1\nmove: {address: 0x20, words: [position_low, position_high]}\n"
    "home: {address: 1, words: [1]}\nstop: {address: 1, words: [2]}\n"
    "status: {alarm: {bit: 15, active_low: true}}\n";

RegisterMap parsed(const std::string& yaml) {
  const TestDirectory directory;
  write_file_atomically(directory / "map.yaml", yaml);
  return read_register_map(directory / "map.yaml");
}

std::string with(const std::string& from, const std::string& to) {
  std::string yaml = kMinimal;
  const auto at = yaml.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return yaml.replace(at, from.size(), to);
}

// The minimal map with `from` replaced by `to` is refused with the message.
void expect_refused(const std::string& from, const std::string& to, const std::string& message) {
  EXPECT_THAT(error_of([&] { parsed(with(from, to)); }),
              AllOf(HasSubstr(message), HasSubstr("map.yaml")));
}

TEST(RegisterMapTest, MinimalMapOmitsWhatTheDriveLacks) {
  const RegisterMap map = parsed(kMinimal);
  EXPECT_EQ(map.name, "small");
  EXPECT_EQ(map.move.address, 0x20);
  ASSERT_EQ(map.move.words.size(), 2u);
  EXPECT_EQ(map.move.words[0].meaning, WordMeaning::kPositionLow);
  EXPECT_EQ(map.move.words[1].meaning, WordMeaning::kPositionHigh);
  EXPECT_EQ(map.stop.words.front().constant, 2);
  EXPECT_FALSE(map.start.exists());
  EXPECT_EQ(map.homed.bit, -1);
  EXPECT_EQ(map.alarm.bit, 15);
  EXPECT_TRUE(map.alarm.active_low);
  EXPECT_EQ(map.alarm_address, -1);
  EXPECT_EQ(map.identity_address, -1);
}

TEST(RegisterMapTest, GenericMapDocumentsEveryKeyAndNoOther) {
  EXPECT_EQ(keys_of_yaml(shipped("generic.yaml")), register_map_keys());
}

TEST(RegisterMapTest, ShippedMapsCanBeRead) {
  for (const std::string& name : shipped_config_names(ConfigKind::kSlider)) {
    EXPECT_FALSE(read_register_map(shipped(name + ".yaml")).name.empty());
  }
  EXPECT_EQ(read_register_map(shipped("generic.yaml")).identity_value, 0x5257);
  EXPECT_EQ(read_register_map(shipped("iai-block.yaml")).status_address, 0x9005);
  EXPECT_EQ(read_register_map(shipped("leadshine-pr0.yaml")).position_address, 0x1014);
}

TEST(RegisterMapTest, MapsThatCannotDriveACarriageAreRefused) {
  struct Case {
    const char *from, *to, *message;
  };
  for (const Case& each :
       {Case{kMinimal, "", "'move.address' is missing"},
        {"stop:", "stopp:", "map.yaml:9: unknown key 'stopp"},
        {"bit: 15", "bit: 16", "'status.alarm.bit'"},
        {"steps_per_mm: 80", "steps_per_mm: 0", "map.yaml:2: 'steps_per_mm'"},
        {"address: 0x20", "address: 0x10000", "'move.address'"},
        {"name: small\n", "", "'name' is missing"},
        {"steps_per_mm: 80\n", "", "'steps_per_mm' is missing"},
        {"speed_per_mm_s: 2\n", "", "'speed_per_mm_s' is missing"},
        {"position_address: 10\n", "", "'position_address' is missing"},
        {"status_address: 12\n", "", "'status_address' is missing"},
        {"stop: {address: 1, words: [2]}\n", "", "'stop.address' is missing"},
        {"words: [2]", "words: []", "'stop.words' is missing"},
        {"position_low, ", "", "position_high and position_low"},
        {"position_low, ", "position_low, position_low, ", "position_high and position_low"},
        {"position_low, ", "position_low, speed_low, ", "speed_high and speed_low"},
        {"acceleration_per_mm_s2: 1", "acceleration_time_to_mm_s: 0", "give one of"},
        {"acceleration_per_mm_s2: 1", "acceleration_per_mm_s2: 1\nacceleration_time_to_mm_s: 1",
         "give one of"},
        {"status: {alarm: {bit: 15, active_low: true}}\n", "", "'status.alarm.bit'"},
        {"words: [2]", "words: [position_low]", "'stop.words' must be numbers"},
        {"position_low", "position_lo", "did you mean 'position_low'?"},
        {"words: [2]", "words: [70000]", "70000 does not fit 16 bits"},
        {"words: [2]", "words: [-1]", "does not fit 16 bits"},
        {"address: 0x20", "address: 0xffff", "reaches beyond register 0xffff"},
        {"status_address: 12", "status_address: 200\none_read: true", "'one_read'"}}) {
    expect_refused(each.from, each.to, each.message);
  }
  EXPECT_THROW(read_register_map("/nowhere/map.yaml"), UsageError);
}

TEST(RegisterMapTest, OneReadMayFillOneRequest) {
  EXPECT_TRUE(parsed(with("status_address: 12", "status_address: 134\none_read: true")).one_read);
}

double log_uniform(double low, double high, std::mt19937_64* random) {
  return std::exp(std::uniform_real_distribution(std::log(low), std::log(high))(*random));
}

RegisterMap map_of(double steps_per_mm, std::vector<BlockWord> move) {
  RegisterMap map;
  map.name = "test";
  map.steps_per_mm = steps_per_mm;
  map.speed_per_mm_s = 1.0;
  map.acceleration_per_mm_s2 = 1.0;
  map.move = {0, std::move(move)};
  return map;
}

std::vector<std::uint16_t> move_words(const RegisterMap& map, double mm,
                                      const MotionProfile& profile = {}) {
  return words_of(map, map.move, mm, profile);
}

TEST(RegisterWordsTest, PositionsSurviveTheRegistersToHalfAStep) {
  std::mt19937_64 random(7);
  RegisterMap map = map_of(1.0, {{WordMeaning::kPositionHigh}, {WordMeaning::kPositionLow}});
  for (int i = 0; i < 20000; ++i) {
    map.steps_per_mm = log_uniform(1e-3, 1e7, &random);
    const double sign = random() % 2 == 0 ? 1.0 : -1.0;
    const double steps = log_uniform(1e-3, 2147483646.0, &random);
    const double mm = sign * std::min(steps / map.steps_per_mm, 1e9);
    const auto words = move_words(map, mm);
    map.low_word_first = false;
    EXPECT_NEAR(mm_from_words(map, words[0], words[1]), mm, 0.5 / map.steps_per_mm * (1.0 + 1e-6));
    map.low_word_first = true;
    EXPECT_EQ(mm_from_words(map, words[1], words[0]), steps_from_mm(map, mm) / map.steps_per_mm);
  }
}

TEST(RegisterWordsTest, TargetsBeyond32BitsAreRefused) {
  const RegisterMap map = map_of(1e6, {{WordMeaning::kPositionHigh}, {WordMeaning::kPositionLow}});
  EXPECT_EQ(steps_from_mm(map, 2147.483647), 2147483647);
  EXPECT_EQ(steps_from_mm(map, -2147.483648), -2147483647 - 1);
  EXPECT_THROW(steps_from_mm(map, 2147.4836475), UsageError);
  EXPECT_THROW(steps_from_mm(map, -2147.4836486), UsageError);
  EXPECT_THROW(move_words(map, 1e8), UsageError);
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
  EXPECT_THAT(move_words(map, 40.0, {400.0 / 3.0, 200.0 / 3.0}),
              ElementsAre(1, 0, 10000, 200, 10000, 10000, 0, 0x10));
}

TEST(RegisterWordsTest, WideSpeedsTakeTwoWords) {
  RegisterMap map = map_of(1.0, {{WordMeaning::kSpeedHigh}, {WordMeaning::kSpeedLow}});
  map.speed_per_mm_s = 1000.0;
  EXPECT_THAT(move_words(map, 0.0, {100.0, 1.0}), ElementsAre(1, 34464));
}

TEST(RegisterWordsTest, SpeedsThatDoNotFitAreRefusedAndNotRoundedIntoRange) {
  const RegisterMap map = map_of(1.0, {{WordMeaning::kSpeed}, {WordMeaning::kAcceleration}});
  EXPECT_THAT(move_words(map, 0.0, {65535.0, 65535.0}), ElementsAre(65535, 65535));
  for (const MotionProfile& profile :
       {MotionProfile{65536.0, 1.0}, {0.4, 1.0}, {1.0, 0.4}, {1.0, 65536.0}}) {
    EXPECT_THROW(move_words(map, 0.0, profile), UsageError);
  }
}

TEST(RegisterWordsTest, FlagsFollowTheirBitAndItsSense) {
  EXPECT_EQ(flag_of(0x8000, StatusBit{}), std::nullopt);
  EXPECT_EQ(flag_of(0x8000, StatusBit{15, false}), true);
  EXPECT_EQ(flag_of(0x7fff, StatusBit{15, false}), false);
  EXPECT_EQ(flag_of(0x0001, StatusBit{0, true}), false);
  EXPECT_EQ(flag_of(0x0000, StatusBit{0, true}), true);
}

}  // namespace
}  // namespace raywalk::capture
