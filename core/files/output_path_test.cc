#include "core/files/output_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

TEST(OutputPathTest, RemovesATrailingSlash) {
  EXPECT_EQ(without_trailing_slash("a/room.lf/"), "a/room.lf");
  EXPECT_EQ(without_trailing_slash("a/room.lf"), "a/room.lf");
  EXPECT_EQ(without_trailing_slash(""), "");
}

TEST(OutputPathTest, ExistingPathIsAnErrorNamingPathAndOption) {
  const TestDirectory directory;
  EXPECT_NO_THROW(require_absent(directory / "free", "--out"));
  std::filesystem::create_directory(directory / "taken");
  std::filesystem::create_symlink(directory / "nowhere", directory / "link");
  for (const char* name : {"taken", "link"}) {
    EXPECT_THAT([&] { require_absent(directory / name, "--thin"); },
                ::testing::ThrowsMessage<Error>((directory / name).string() +
                                                ": exists already; remove it or choose another "
                                                "--thin"));
  }
}

}  // namespace
}  // namespace raywalk
