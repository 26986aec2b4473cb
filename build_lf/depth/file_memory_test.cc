#include "build_lf/depth/file_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "core/base/test_error.h"
#include "core/files/test_directory.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

TEST(FileMemoryTest, HoldsValuesAndLeavesNoFiles) {
  const TestDirectory directory;
  FileMemory memory(directory.path());
  {
    std::pmr::vector<std::uint64_t> values(1'000'003, &memory);
    EXPECT_EQ(std::accumulate(values.begin(), values.end(), std::uint64_t{0}), 0U);
    std::iota(values.begin(), values.end(), std::uint64_t{7});
    std::pmr::vector<std::uint16_t> others(&memory);
    for (int i = 0; i < 5000; ++i) others.push_back(static_cast<std::uint16_t>(i));
    const auto moved = std::move(values);
    for (std::size_t i = 0; i < moved.size(); i += 997) ASSERT_EQ(moved[i], i + 7);
    for (std::size_t i = 0; i < others.size(); ++i) ASSERT_EQ(others[i], i);
    EXPECT_TRUE(fs::is_empty(directory.path())) << "while in use";
  }
  EXPECT_TRUE(fs::is_empty(directory.path()));
}

TEST(FileMemoryTest, NamesTheDirectoryThatCannotHoldTheValues) {
  const TestDirectory directory;
  const fs::path missing = directory.path() / "missing";
  FileMemory memory(missing);
  const std::string error = error_of([&] { const std::pmr::vector<int> values(1000, &memory); });
  EXPECT_NE(error.find(missing.string() + ": cannot write there"), std::string::npos) << error;
  EXPECT_NE(error.find("No such file"), std::string::npos) << error;
}

// As on a full disk: the blocks cannot be had. Without reserving them, writing would end the test.
TEST(FileMemoryTest, ReportsAFullDisk) {
  const TestDirectory directory;
  FileMemory memory(directory.path());
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1 << 20, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error =
      error_of([&] { const std::pmr::vector<char> values(2 << 20, &memory); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(error, directory.path().string() +
                       ": cannot hold 2 MB of intermediate values: File too large");
  const std::pmr::vector<char> values(2 << 20, &memory);
  EXPECT_EQ(values.back(), 0);
}

}  // namespace
}  // namespace raywalk::build_lf
