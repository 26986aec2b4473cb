// Tests of page-cache advice; room_test covers opening datasets.
#include "core/room/mapped_dataset.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

#include "core/files/test_directory.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

constexpr std::size_t kRows = 4;
constexpr std::size_t kRowBytes = std::size_t{1} << 20;

std::vector<std::uint8_t> row_values(std::size_t row) {
  std::vector<std::uint8_t> values(kRowBytes);
  std::iota(values.begin(), values.end(), static_cast<std::uint8_t>(row));
  return values;
}

// A file of kRows rows, dropped from the page cache if the file system supports it.
std::filesystem::path write_cold(const TestDirectory& directory) {
  const std::filesystem::path path = directory / "cold.h5";
  Hdf5File file = Hdf5File::create(path);
  file.create_contiguous("rays", ElementType::kUint8, {kRows, kRowBytes});
  for (std::size_t row = 0; row < kRows; ++row)
    file.write_slab("rays", row, row_values(row).data());
  file.close();
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  EXPECT_EQ(::fsync(descriptor), 0);
  EXPECT_EQ(::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED), 0);
  ::close(descriptor);
  return path;
}

TEST(MappedDataset, FetchesLittleMoreThanRequested) {
  const TestDirectory directory;
  const MappedDataset mapped(Hdf5File::open(write_cold(directory)), "rays", ElementType::kUint8);
  mapped.expect_scattered_reads();
  const auto* rays = static_cast<const std::uint8_t*>(mapped.data());
  const std::uint8_t* const middle = rays + 2 * kRowBytes + kRowBytes / 2;
  if (mapped.in_memory(middle)) GTEST_SKIP() << "this file system does not drop cached pages";
  // More than the system reads per call.
  mapped.fetch(rays + 2 * kRowBytes, kRowBytes);
  for (int i = 0; i < 1000 && !mapped.in_memory(rays + 3 * kRowBytes - 1); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(mapped.in_memory(rays + 2 * kRowBytes));
  EXPECT_TRUE(mapped.in_memory(middle));
  EXPECT_TRUE(mapped.in_memory(rays + 3 * kRowBytes - 1));
  EXPECT_FALSE(mapped.in_memory(rays + kRowBytes / 2));
}

}  // namespace
}  // namespace raywalk
