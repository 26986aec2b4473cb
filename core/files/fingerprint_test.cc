#include "core/files/fingerprint.h"

#include <gtest/gtest.h>

#include <chrono>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/sha256.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

class FingerprintTest : public testing::Test {
 protected:
  FingerprintTest() { write_file_atomically(file_, "abc"); }

  TestDirectory directory_;
  const fs::path file_ = directory_ / "frame.png";
};

TEST_F(FingerprintTest, StampHasSizeAndTime) {
  const auto time = fs::last_write_time(file_);
  EXPECT_EQ(stamp_of(file_).bytes, 3u);
  EXPECT_EQ(stamp_of(file_).time, time.time_since_epoch().count());
  EXPECT_EQ(stamp_of(file_).text(), "3 " + std::to_string(time.time_since_epoch().count()));
}

TEST_F(FingerprintTest, StampChangesWithTheTime) {
  const std::string before = stamp_of(file_).text();
  fs::last_write_time(file_, fs::last_write_time(file_) + std::chrono::seconds(1));
  EXPECT_NE(stamp_of(file_).text(), before);
}

TEST_F(FingerprintTest, StampOfAMissingFileNamesIt) {
  try {
    stamp_of(directory_ / "nothing.png");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("nothing.png: cannot be read"), std::string::npos);
  }
}

TEST_F(FingerprintTest, ChecksumOfAFileIsThatOfItsBytes) {
  EXPECT_EQ(sha256_of_file(file_), sha256_hex("abc"));
  EXPECT_THROW(sha256_of_file(directory_ / "nothing.png"), Error);
  EXPECT_THROW(sha256_of_file(directory_.path()), Error);
  const std::string large(3'000'000, 'x');  // more than is read at once
  write_file_atomically(file_, large);
  EXPECT_EQ(sha256_of_file(file_), sha256_hex(large));
}

TEST(Sha256OfPixels, DoesNotDependOnGapsBetweenRows) {
  const cv::Mat whole = (cv::Mat_<std::uint8_t>(2, 3) << 'a', 'b', 'x', 'c', 'd', 'x');
  const cv::Mat part = whole.colRange(0, 2);
  ASSERT_FALSE(part.isContinuous());
  EXPECT_EQ(sha256_of_pixels(part), sha256_hex("abcd"));
  EXPECT_EQ(sha256_of_pixels(part.clone()), sha256_hex("abcd"));
}

}  // namespace
}  // namespace raywalk
