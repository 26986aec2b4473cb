#include "core/files/fingerprint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// Examples of FIPS 180-2, appendix B, and the empty message.
TEST(Fingerprint, GivesThePublishedChecksums) {
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Fingerprint, OfAFileIsThatOfItsBytes) {
  const TestDirectory directory;
  write_file_atomically(directory / "frame.png", "abc");
  EXPECT_EQ(sha256_of_file(directory / "frame.png"), sha256_hex("abc"));
  EXPECT_THROW(sha256_of_file(directory / "nothing.png"), Error);
  EXPECT_THROW(sha256_of_file(directory.path()), Error);
}

TEST(Fingerprint, OfPixelsDoesNotDependOnGapsBetweenRows) {
  const cv::Mat whole = (cv::Mat_<std::uint8_t>(2, 3) << 'a', 'b', 'x', 'c', 'd', 'x');
  const cv::Mat part = whole.colRange(0, 2);
  ASSERT_FALSE(part.isContinuous());
  EXPECT_EQ(sha256_of_pixels(part), sha256_hex("abcd"));
}

TEST(Fingerprint, StampChangesWithSizeAndTime) {
  const TestDirectory directory;
  const fs::path file = directory / "frame.png";
  write_file_atomically(file, "abc");
  const std::string before = stamp_of(file).text();
  EXPECT_EQ(stamp_of(file).bytes, 3U);
  fs::last_write_time(file, fs::last_write_time(file) + std::chrono::seconds(1));
  EXPECT_NE(stamp_of(file).text(), before);
  EXPECT_THAT(error_of([&] { stamp_of(directory / "nothing.png"); }),
              testing::HasSubstr("nothing.png: cannot be read"));
}

}  // namespace
}  // namespace raywalk
