#include "capture/slider/register_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/files/test_yaml_keys.h"

namespace raywalk::capture {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

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

void expect_refused(const std::string& yaml, const std::string& message) {
  try {
    parsed(yaml);
    ADD_FAILURE() << yaml;
  } catch (const UsageError& e) {
    EXPECT_THAT(e.what(), HasSubstr(message));
    EXPECT_THAT(e.what(), HasSubstr("map.yaml"));
  }
}

TEST(RegisterMapTest, MinimalMapOmitsWhatTheDriveLacks) {
  const RegisterMap map = parsed(kMinimal);
  EXPECT_EQ(map.name, "small");
  EXPECT_EQ(map.move.address, 0x20);
  ASSERT_EQ(map.move.words.size(), 2u);
  EXPECT_EQ(map.move.words[0].meaning, WordMeaning::kPositionLow);
  EXPECT_EQ(map.move.words[1].meaning, WordMeaning::kPositionHigh);
  EXPECT_EQ(map.stop.words.front().constant, 2);
  EXPECT_FALSE(map.start || map.reset_alarm || map.homed || map.moving);
  EXPECT_EQ(map.alarm->bit, 15);
  EXPECT_TRUE(map.alarm->active_low);
  EXPECT_EQ(map.alarm_address, -1);
  EXPECT_EQ(map.identity_address, -1);
}

TEST(RegisterMapTest, GenericMapDocumentsEveryKeyAndNoOther) {
  EXPECT_EQ(keys_of_yaml(shipped("generic.yaml")), register_map_keys());
}

TEST(RegisterMapTest, ShippedMapsCanBeRead) {
  EXPECT_EQ(read_register_map(shipped("generic.yaml")).identity_value, 0x5257);
  EXPECT_EQ(read_register_map(shipped("iai-block.yaml")).status_address, 0x9005);
  EXPECT_EQ(read_register_map(shipped("leadshine-pr0.yaml")).position_address, 0x1014);
}

TEST(RegisterMapTest, MistakesOfSpellingAreNamedWithTheirLine) {
  expect_refused(with("stop:", "stopp:"), "map.yaml:9: unknown key 'stopp");
  expect_refused(with("bit: 15", "bit: 16"), "'status.alarm.bit'");
  expect_refused(with("steps_per_mm: 80", "steps_per_mm: 0"), "map.yaml:2: 'steps_per_mm'");
  expect_refused(with("address: 0x20", "address: 0x10000"), "'move.address'");
}

TEST(RegisterMapTest, MapsThatCannotDriveACarriageAreRefused) {
  expect_refused("", "'move.address' is missing");
  expect_refused(with("name: small\n", ""), "'name' is missing");
  expect_refused(with("steps_per_mm: 80\n", ""), "'steps_per_mm' is missing");
  expect_refused(with("speed_per_mm_s: 2\n", ""), "'speed_per_mm_s' is missing");
  expect_refused(with("position_address: 10\n", ""), "'position_address' is missing");
  expect_refused(with("status_address: 12\n", ""), "'status_address' is missing");
  expect_refused(with("stop: {address: 1, words: [2]}\n", ""), "'stop.address' is missing");
  expect_refused(with("words: [2]", "words: []"), "'stop.words' is missing");
  expect_refused(with("position_low, ", ""), "position_high and position_low");
  expect_refused(with("position_low, ", "position_low, position_low, "),
                 "position_high and position_low");
  expect_refused(with("position_low, ", "position_low, speed_low, "), "speed_high and speed_low");
  expect_refused(with("acceleration_per_mm_s2: 1", "acceleration_time_to_mm_s: 0"), "give one of");
  expect_refused(
      with("acceleration_per_mm_s2: 1", "acceleration_per_mm_s2: 1\nacceleration_time_to_mm_s: 1"),
      "give one of");
  expect_refused(with("status: {alarm: {bit: 15, active_low: true}}\n", ""), "'status.alarm.bit'");
  expect_refused(with("status: {alarm: {bit: 15, active_low: true}}\n", "alarm_address: 3\n"),
                 "'status.alarm.bit', which says when");
}

TEST(RegisterMapTest, WordsAreNumbersOrQuantities) {
  expect_refused(with("words: [2]", "words: [position_low]"), "'stop.words' must be numbers");
  expect_refused(with("position_low", "position_lo"), "did you mean 'position_low'?");
  expect_refused(with("words: [2]", "words: [70000]"), "70000 does not fit 16 bits");
  expect_refused(with("words: [2]", "words: [-1]"), "does not fit 16 bits");
  expect_refused(with("address: 0x20", "address: 0xffff"), "reaches beyond register 0xffff");
}

TEST(RegisterMapTest, OneReadMustFitOneRequest) {
  expect_refused(with("status_address: 12", "status_address: 200\none_read: true"), "'one_read'");
  EXPECT_TRUE(parsed(with("status_address: 12", "status_address: 134\none_read: true")).one_read);
}

TEST(RegisterMapTest, MissingFileIsNamed) {
  EXPECT_THROW(read_register_map("/nowhere/map.yaml"), UsageError);
}

}  // namespace
}  // namespace raywalk::capture
