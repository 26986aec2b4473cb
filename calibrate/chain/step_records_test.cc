#include "calibrate/chain/step_records.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

class StepRecordsTest : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    write_file_atomically(directory_ / name, text);
  }
  bool is_done(const std::string& fingerprint = "abc") const {
    return StepRecords(directory_.path()).done("mask", fingerprint).has_value();
  }
  void note() const {
    write("mask.png", "a picture");
    write("big.bin", std::string((std::size_t{1} << 20) + 1, 'x'));
    StepRecords(directory_.path()).note("mask", "abc", 1.5, {"mask.png", "big.bin"});
  }

  TestDirectory directory_;
};

TEST_F(StepRecordsTest, StepIsDoneOnlyWithTheSameInputs) {
  EXPECT_FALSE(is_done());
  note();
  EXPECT_TRUE(is_done());
  EXPECT_FALSE(is_done("abd"));
  const auto last = StepRecords(directory_.path()).last("mask");
  ASSERT_TRUE(last);
  EXPECT_EQ(last->seconds, 1.5);
  EXPECT_FALSE(StepRecords(directory_.path()).done("grid", "abc"));
}

TEST_F(StepRecordsTest, StepWhoseOutputsChangedIsNotDone) {
  note();
  write("mask.png", "b picture");
  EXPECT_FALSE(is_done());
  write("mask.png", "a picture");
  EXPECT_TRUE(is_done());  // compared by content
  write("big.bin", std::string((std::size_t{1} << 20) + 2, 'x'));
  EXPECT_FALSE(is_done());
  note();
  std::filesystem::remove(directory_ / "mask.png");
  EXPECT_FALSE(is_done());
}

TEST_F(StepRecordsTest, ForgottenStepIsNotDone) {
  note();
  StepRecords(directory_.path()).forget("mask");
  EXPECT_FALSE(is_done());
}

TEST_F(StepRecordsTest, DamagedRecordsCountAsNone) {
  note();
  for (const char* bad : {"", "{", "[]", "{\"format_version\": 2, \"steps\": {}}",
                          "{\"format_version\": 4294967297, \"steps\": {}}",
                          "{\"format_version\": 1.5, \"steps\": {}}",
                          "{\"format_version\": 1, \"steps\": {\"mask\": 3}}"}) {
    write("steps.json", bad);
    EXPECT_FALSE(is_done()) << bad;
  }
  note();
  EXPECT_TRUE(is_done());
}

TEST_F(StepRecordsTest, MissingOutputIsAnError) {
  StepRecords records(directory_.path());
  EXPECT_ANY_THROW(records.note("mask", "abc", 1.0, {"nothing.png"}));
  EXPECT_FALSE(is_done());
}

}  // namespace
}  // namespace raywalk::calibrate
