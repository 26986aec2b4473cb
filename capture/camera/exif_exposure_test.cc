#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "capture/camera/osc_exposure.h"
#include "core/files/exif.h"

namespace raywalk::capture {
namespace {

std::string plain_jpeg() {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", cv::Mat(16, 32, CV_8UC3, cv::Scalar(30, 60, 90)), bytes);
  return {bytes.begin(), bytes.end()};
}

// The exposure time in units of 10 microseconds.
std::string jpeg_with(double shutter_s, int iso) {
  const auto time = static_cast<std::uint32_t>(std::lround(1e5 * shutter_s));
  const std::string block =
      exif_block({}, {rational_entry(EXIF_TAG_EXPOSURE_TIME, time, 100'000),
                      short_entry(EXIF_TAG_ISO_SPEED_RATINGS, static_cast<std::uint16_t>(iso))});
  return with_app1(plain_jpeg(), kExifIdentifier, block);
}

TEST(ExifExposure, IsReadBackFromFastToSlow) {
  for (const double shutter_s : {1.0 / 25000.0, 1.0 / 640.0, 1.0 / 60.0, 0.125, 0.4, 1.6, 60.0}) {
    const auto exposure = exif_exposure(jpeg_with(shutter_s, 3200));
    ASSERT_TRUE(exposure);
    EXPECT_NEAR(exposure->shutter_s / shutter_s, 1.0, 0.01);
    EXPECT_EQ(exposure->iso, 3200);
  }
}

TEST(ExifExposure, IsNoneIfTheTagsAreMissing) {
  EXPECT_FALSE(exif_exposure(plain_jpeg()));
  EXPECT_FALSE(exif_exposure(""));
  EXPECT_FALSE(exif_exposure("<html></html>"));
  EXPECT_FALSE(exif_exposure(jpeg_with(0.01, 0)));
}

TEST(ExifExposure, DamagedDataAreNoneOrPositiveNeverACrash) {
  const std::string whole = jpeg_with(0.01, 100);
  std::mt19937 random(3);
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = whole.substr(0, 1 + random() % whole.size());
    for (int change = 0; change < 4; ++change) {
      damaged[random() % std::min<std::size_t>(damaged.size(), 400)] = static_cast<char>(random());
    }
    if (const auto exposure = exif_exposure(damaged)) {
      EXPECT_GT(exposure->shutter_s, 0.0);
      EXPECT_GT(exposure->iso, 0);
    }
  }
}

}  // namespace
}  // namespace raywalk::capture
