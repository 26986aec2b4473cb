#include "capture/camera/check_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "capture/base/device_fault.h"

namespace raywalk::capture {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::string encoded(const std::string& extension, int width, int height) {
  std::vector<unsigned char> bytes;
  cv::imencode(extension, cv::Mat(height, width, CV_8UC3, cv::Scalar(30, 60, 90)), bytes);
  return {bytes.begin(), bytes.end()};
}

// The error message for bytes that are not a picture.
std::string refusal_of(const std::string& bytes, PanoramaSize expected = {}) {
  try {
    check_picture(bytes, expected, "camera, R0010001.JPG");
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kBadPicture);
    EXPECT_THAT(fault.what(), StartsWith("camera, R0010001.JPG: "));
    EXPECT_THAT(fault.what(), Not(HasSubstr("\n")));
    return fault.what();
  }
  ADD_FAILURE() << "accepted";
  return {};
}

TEST(CheckPicture, TellsFormatAndSizeOfAWholePicture) {
  const CheckedPicture jpeg = check_picture(encoded(".jpg", 64, 32), {64, 32}, "camera");
  EXPECT_EQ(jpeg.extension, "jpg");
  EXPECT_EQ(jpeg.size, (PanoramaSize{64, 32}));
  const CheckedPicture png = check_picture(encoded(".png", 48, 24), {}, "camera");
  EXPECT_EQ(png.extension, "png");
  EXPECT_EQ(png.size, (PanoramaSize{48, 24}));
}

TEST(CheckPicture, NamesWhatWasSentInstead) {
  EXPECT_THAT(refusal_of(""), HasSubstr("empty"));
  EXPECT_THAT(refusal_of("<!DOCTYPE html><html></html>"), HasSubstr("web page"));
  EXPECT_THAT(refusal_of("\n  <HTML>\n<body>Log in</body></HTML>"), HasSubstr("web page"));
  EXPECT_THAT(refusal_of("{\"error\": {\"code\": \"disabledCommand\"}}"),
              HasSubstr("disabledCommand"));
  EXPECT_THAT(refusal_of("GIF89a......"), HasSubstr("JPEG or PNG"));
  EXPECT_THAT(refusal_of(encoded(".bmp", 8, 4)), HasSubstr("JPEG or PNG"));
}

TEST(CheckPicture, NoPrefixOfAPictureIsAccepted) {
  for (const std::string extension : {".jpg", ".png"}) {
    const std::string whole = encoded(extension, 64, 32);
    for (std::size_t length = 1; length < whole.size(); ++length) {
      ASSERT_THAT(refusal_of(whole.substr(0, length)), HasSubstr("cut short"));
    }
  }
}

TEST(CheckPicture, AnotherSizeIsNamedWithTheExpectedOne) {
  const std::string said = refusal_of(encoded(".jpg", 32, 16), {64, 32});
  EXPECT_THAT(said, HasSubstr("32x16"));
  EXPECT_THAT(said, HasSubstr("64x32"));
}

}  // namespace
}  // namespace raywalk::capture
