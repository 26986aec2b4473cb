#include "core/base/usable_memory.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <string>

#include "core/files/test_directory.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

class ControlGroupTest : public testing::Test {
 protected:
  void write(const fs::path& file, const std::string& text) const {
    fs::create_directories((directory_ / file.string()).parent_path());
    std::ofstream(directory_ / file.string()) << text;
  }
  std::uint64_t limit(const std::string& membership) const {
    write("membership", membership);
    return control_group_limit_bytes(directory_.path() / "membership",
                                     directory_.path() / "groups");
  }

  TestDirectory directory_;
};

TEST_F(ControlGroupTest, TakesTheSmallestLimitAroundAGroupOfVersion2) {
  write("groups/a/b/memory.max", "4000\n");
  write("groups/a/memory.max", "3000\n");
  write("groups/other/memory.max", "10\n");
  EXPECT_EQ(limit("0::/a/b\n"), 3000U);
  write("groups/a/memory.max", "max\n");
  EXPECT_EQ(limit("0::/a/b\n"), 4000U);
  write("groups/a/b/memory.max", "max\n");
  EXPECT_EQ(limit("0::/a/b\n"), kUnlimited);
}

TEST_F(ControlGroupTest, ReadsTheMemoryControllerOfVersion1) {
  write("groups/memory/job/memory.limit_in_bytes", "536870912\n");
  write("groups/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(limit("5:cpu,cpuacct:/x\n4:memory:/job\n0::/\n"), 536870912U);
  EXPECT_EQ(limit("5:memory_of_others:/job\n"), kUnlimited);
}

TEST_F(ControlGroupTest, FindsTheGroupOfAContainerAtTheMount) {
  write("groups/memory.max", "2000\n");
  EXPECT_EQ(limit("0::/unseen/outside\n"), 2000U);
}

TEST_F(ControlGroupTest, NothingReadableSetsNoLimit) {
  EXPECT_EQ(limit(""), kUnlimited);
  EXPECT_EQ(limit("nonsense\n0::\n::\n"), kUnlimited);
  EXPECT_EQ(control_group_limit_bytes(directory_.path() / "missing", "/missing"), kUnlimited);
}

TEST(UsableMemoryTest, IsNotMoreThanTheMachineHas) {
  std::ifstream info("/proc/meminfo");
  std::string label;
  std::uint64_t kilobytes = 0;
  ASSERT_TRUE(info >> label >> kilobytes);
  EXPECT_GT(usable_memory_bytes(), 0U);
  EXPECT_LE(usable_memory_bytes(), 1024 * kilobytes);
}

}  // namespace
}  // namespace raywalk
