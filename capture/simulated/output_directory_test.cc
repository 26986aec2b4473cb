#include "capture/simulated/output_directory.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

TEST(OutputDirectoryTest, AppearsWhenCommitted) {
  const TestDirectory parent;
  OutputDirectory output(parent / "out");
  std::ofstream(output.make("inner") / "file") << "text";
  EXPECT_FALSE(fs::exists(parent / "out"));
  output.commit();
  EXPECT_TRUE(fs::exists(parent / "out/inner/file"));
  EXPECT_EQ(parent.entries(), 1U);
}

TEST(OutputDirectoryTest, LeavesNothingWithoutCommit) {
  const TestDirectory parent;
  {
    const OutputDirectory output(parent / "out");
    std::ofstream(output.path() / "file") << "text";
    EXPECT_EQ(parent.entries(), 1U);
  }
  EXPECT_EQ(parent.entries(), 0U);
}

TEST(OutputDirectoryTest, ExistingTargetIsRefusedAndKept) {
  const TestDirectory parent;
  fs::create_directory(parent / "out");
  EXPECT_THROW(OutputDirectory(parent / "out"), Error);
  EXPECT_THROW(OutputDirectory(parent / "out/"), Error);
  OutputDirectory late(parent / "late");
  std::ofstream(parent / "late") << "came in between";
  EXPECT_THROW(late.commit(), Error);
  EXPECT_TRUE(fs::is_regular_file(parent / "late"));
}

TEST(OutputDirectoryTest, ReplacesOnlyAMarkedCapture) {
  const TestDirectory parent;
  {
    OutputDirectory first(parent / "out");
    std::ofstream(first.make("capture") / "old.jpg") << "text";
    first.mark();
    first.commit();
  }
  OutputDirectory second(parent / "out", true);
  EXPECT_TRUE(fs::exists(parent / "out/capture/old.jpg")) << "until the new one is complete";
  std::ofstream(second.make("capture") / "new.jpg") << "text";
  second.mark();
  second.commit();
  EXPECT_FALSE(fs::exists(parent / "out/capture/old.jpg"));
  EXPECT_TRUE(fs::exists(parent / "out/capture/new.jpg"));
  EXPECT_EQ(parent.entries(), 1U);

  // Photographs of one's own in folders of the same names.
  fs::remove(parent / "out/virtual-room.json");
  EXPECT_THROW(OutputDirectory(parent / "out", true), Error);
  EXPECT_TRUE(fs::exists(parent / "out/capture/new.jpg"));
}

// As left by a killed run of the same process id.
TEST(OutputDirectoryTest, LeftoversAreNotReused) {
  const TestDirectory parent;
  fs::path stale;
  {
    const OutputDirectory first(parent / "out");
    stale = first.path();
  }
  fs::create_directory(stale);
  std::ofstream(stale / "leftover") << "text";
  OutputDirectory output(parent / "out");
  EXPECT_TRUE(fs::is_empty(output.path()));
  output.commit();
  EXPECT_TRUE(fs::is_empty(parent / "out"));
  EXPECT_TRUE(fs::exists(stale / "leftover")) << "it may be another's";
}

TEST(OutputDirectoryTest, TwoInOneProcessAreSeparate) {
  const TestDirectory parent;
  const OutputDirectory one(parent / "out"), other(parent / "out");
  EXPECT_NE(one.path(), other.path());
}

TEST(OutputDirectoryTest, EmptyNameIsRefused) { EXPECT_THROW(OutputDirectory(""), UsageError); }

TEST(OutputDirectoryTest, MissingParentIsAnError) {
  const TestDirectory parent;
  EXPECT_THROW(OutputDirectory(parent / "missing/out"), Error);
}

}  // namespace
}  // namespace raywalk::capture
