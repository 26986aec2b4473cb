#include "build_lf/pack/partial_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class PartialRoomTest : public ::testing::Test {
 protected:
  std::string error_of(const std::string& fingerprint) {
    try {
      PartialRoom room(out_, fingerprint);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }
  void finish_volume() { write_file_atomically(partial_ / "lines" / "x0.h5", "volume"); }

  TestDirectory directory_;
  fs::path out_ = directory_ / "room.lf";
  fs::path partial_ = directory_ / "room.lf.partial";
};

TEST_F(PartialRoomTest, NothingIsLeftWithoutAFinishedVolume) {
  { const PartialRoom room(out_, "a"); }
  EXPECT_EQ(directory_.entries(), 0U);
}

TEST_F(PartialRoomTest, FinishedVolumesAreKeptForTheSameInputsOnly) {
  {
    const PartialRoom room(out_, "a");
    finish_volume();
  }
  EXPECT_THAT(error_of("b"), HasSubstr(partial_.string()));
  EXPECT_TRUE(fs::exists(partial_ / "lines" / "x0.h5"));
  EXPECT_EQ(error_of("a"), "no error");
}

TEST_F(PartialRoomTest, OtherInputsStartOverIfNothingIsFinished) {
  fs::create_directories(partial_ / "lines");
  write_file_atomically(partial_ / "inputs.sha256", "a");
  EXPECT_EQ(error_of("b"), "no error");
}

TEST_F(PartialRoomTest, ConcurrentRunsAreRejected) {
  PartialRoom room(out_, "a");
  EXPECT_THAT(error_of("a"), HasSubstr("another raywalk-build-lf"));
  EXPECT_TRUE(fs::exists(partial_));
}

TEST_F(PartialRoomTest, CompletingRenamesAndCleansUp) {
  {
    PartialRoom room(out_, "a");
    finish_volume();
    room.complete();
  }
  EXPECT_TRUE(fs::exists(out_ / "lines" / "x0.h5"));
  EXPECT_FALSE(fs::exists(partial_));
  EXPECT_EQ(std::distance(fs::directory_iterator(out_), {}), 1);
  EXPECT_THAT(error_of("a"), HasSubstr("exists already"));
}

TEST_F(PartialRoomTest, ReplacingStartsAfreshAndKeepsTheRoomUntilItIsComplete) {
  fs::create_directories(out_ / "lines");
  write_file_atomically(out_ / "manifest.json", "{\"format\": \"raywalk-room\"}");
  write_file_atomically(out_ / "lines" / "old.h5", "volume");
  {
    const PartialRoom stopped(out_, "a", true);
    finish_volume();
  }
  EXPECT_TRUE(fs::exists(out_ / "lines" / "old.h5"));
  PartialRoom room(out_, "b", true);
  EXPECT_FALSE(fs::exists(partial_ / "lines" / "x0.h5")) << "of other inputs";
  write_file_atomically(partial_ / "lines" / "x1.h5", "volume");
  room.complete();
  EXPECT_TRUE(fs::exists(out_ / "lines" / "x1.h5"));
  EXPECT_FALSE(fs::exists(out_ / "lines" / "old.h5"));
  EXPECT_EQ(directory_.entries(), 1U);
}

TEST_F(PartialRoomTest, OnlyARoomIsReplaced) {
  fs::create_directory(out_);
  write_file_atomically(out_ / "thesis.txt", "mine");
  EXPECT_THROW(PartialRoom(out_, "a", true), Error);
  EXPECT_EQ(read_file(out_ / "thesis.txt"), "mine");
  EXPECT_FALSE(fs::exists(partial_));
}

TEST_F(PartialRoomTest, RoomCreatedMeanwhileIsNotReplaced) {
  PartialRoom room(out_, "a");
  fs::create_directory(out_);
  EXPECT_THROW(room.complete(), Error);
}

}  // namespace
}  // namespace raywalk::build_lf
