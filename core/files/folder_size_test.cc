#include "core/files/folder_size.h"

#include <gtest/gtest.h>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

TEST(FolderSize, CountsFilesAtAnyDepth) {
  const TestDirectory directory;
  EXPECT_EQ(bytes_in(directory.path()), 0U);
  std::filesystem::create_directories(directory.path() / "a" / "b");
  write_file_atomically(directory.path() / "one", std::string(3, 'x'));
  write_file_atomically(directory.path() / "a" / "b" / "two", std::string(40, 'x'));
  EXPECT_EQ(bytes_in(directory.path()), 43U);
  EXPECT_EQ(bytes_in(directory.path() / "missing"), 0U);
}

}  // namespace
}  // namespace raywalk
