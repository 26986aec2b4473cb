#include "build_lf/depth/station_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "build_lf/depth/depth_test_room.h"
#include "core/panorama/transposed_border.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kPictureSize{128, 64};

SyntheticRoomSpec small_line() {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.spacing_m = 0.25;
  spec.scene.texture_wavelength_m = 0.5;
  return spec;
}

// Largest and mean difference of one channel of two pictures.
struct Difference {
  int most = 0;
  double mean = 0.0;
};

Difference difference_of(const StationPicture& a, const StationPicture& b, int channel) {
  Difference difference;
  for (size_t i = 0; i < a.samples.size(); ++i) {
    const int d = std::abs(channel_of(a.samples[i], channel) - channel_of(b.samples[i], channel));
    difference.most = std::max(difference.most, d);
    difference.mean += d / static_cast<double>(a.samples.size());
  }
  return difference;
}

TEST(StationImageTest, HasAPanoramasColumnsAsRows) {
  const SyntheticRoomSpec spec = small_line();
  const DepthTestRoom room(spec);
  const cv::Mat image = station_image(room.room(), {0, 2}, kPictureSize);
  const cv::Mat frame =
      render_scene(spec.scene, room.grid().lines[0].stations[2].position_m, spec.width);
  ASSERT_EQ(image.size(), cv::Size(64, 128));
  for (int u = 0; u < 128; ++u) {
    for (int v = 0; v < 64; ++v) {
      const auto& bgr = frame.at<cv::Vec3b>(v, u);
      ASSERT_EQ(image.at<cv::Vec3b>(u, v), cv::Vec3b(bgr[2], bgr[1], bgr[0]));
    }
  }
}

TEST(StationImageTest, IsReducedByTheMean) {
  const DepthTestRoom room(small_line());
  const cv::Mat full = station_image(room.room(), {0, 1}, kPictureSize);
  const cv::Mat half = station_image(room.room(), {0, 1}, {64, 32});
  ASSERT_EQ(half.size(), cv::Size(32, 64));
  for (int u = 0; u < 64; ++u) {
    for (int v = 0; v < 32; ++v) {
      const auto at = [&](int du, int dv) { return full.at<cv::Vec3b>(2 * u + du, 2 * v + dv)[1]; };
      const double mean = 0.25 * (at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1));
      ASSERT_NEAR(half.at<cv::Vec3b>(u, v)[1], mean, 1.0);
    }
  }
}

TEST(StationImageTest, WrapsAroundTheSphere) {
  const DepthTestRoom room(small_line());
  const cv::Mat image = station_image(room.room(), {0, 0}, kPictureSize);
  const cv::Mat bordered = with_border(image, 5);
  ASSERT_EQ(bordered.size(), cv::Size(74, 138));
  EXPECT_EQ(bordered.at<cv::Vec3b>(4, 25), image.at<cv::Vec3b>(127, 20));
  EXPECT_EQ(bordered.at<cv::Vec3b>(133, 25), image.at<cv::Vec3b>(0, 20));
  EXPECT_EQ(bordered.at<cv::Vec3b>(25, 4), image.at<cv::Vec3b>(20, 0));
  EXPECT_EQ(bordered.at<cv::Vec3b>(25, 69), image.at<cv::Vec3b>(20, 63));
  EXPECT_EQ(cv::norm(without_border(bordered, 5), image, cv::NORM_INF), 0.0);
}

TEST(StationPictureTest, HoldsFourSamplesPerPixelAroundItsColour) {
  const DepthTestRoom room(small_line());
  const cv::Mat image = station_image(room.room(), {0, 2}, kPictureSize);
  const auto picture = make_station_picture(room.room(), {0, 2}, kPictureSize, {}, {});
  ASSERT_EQ(picture.size, (PanoramaSize{256, 128}));
  ASSERT_EQ(picture.samples.size(), size_t{256 * 128});
  // Mean difference of each pixel's samples from those of the pixel at the given offset.
  const auto mean_difference = [&](int columns_on, int rows_on) {
    double sum = 0.0;
    for (int su = 4; su < 252; ++su) {
      for (int sv = 4; sv < 124; ++sv) {
        const MatchingSample sample = picture.samples[static_cast<size_t>(su * 128 + sv)];
        const auto& pixel = image.at<cv::Vec3b>(su / 2 + columns_on, sv / 2 + rows_on);
        for (int c = 0; c < 3; ++c) sum += std::abs(channel_of(sample, c) - pixel[c]);
      }
    }
    return sum / (248 * 120 * 3);
  };
  const double here = mean_difference(0, 0);
  EXPECT_LT(here, 9.0);
  for (const int on : {-1, 1}) {
    EXPECT_GT(mean_difference(on, 0), 2.0 * here);
    EXPECT_GT(mean_difference(0, on), 2.0 * here);
  }
}

TEST(StationPictureTest, AppliesTheGain) {
  const DepthTestRoom room(small_line());
  const DepthTestRoom darker(small_line(), [](StationIndex, cv::Mat* frame) { *frame *= 0.7; });
  const auto expected = make_station_picture(room.room(), {0, 2}, kPictureSize, {}, {});
  const float gain = 1.0f / 0.7f;
  const auto picture =
      make_station_picture(darker.room(), {0, 2}, kPictureSize, {{gain, gain, gain}}, {});
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_LE(difference_of(picture, expected, channel).most, 2);
  }
}

TEST(StationPictureTest, DetailIsNearlyIndependentOfExposure) {
  const DepthTestRoom room(small_line());
  const DepthTestRoom darker(small_line(), [](StationIndex, cv::Mat* frame) { *frame *= 0.6; });
  const auto bright = make_station_picture(room.room(), {0, 2}, kPictureSize, {}, {});
  const auto dark = make_station_picture(darker.room(), {0, 2}, kPictureSize, {}, {});
  EXPECT_GT(difference_of(bright, dark, 0).mean, 30.0);
  EXPECT_LT(difference_of(bright, dark, 3).mean, 8.0);
}

TEST(StationPictureTest, MarksInvalidPixels) {
  const DepthTestRoom room(small_line());
  cv::Mat valid(kPictureSize.height, kPictureSize.width, CV_8UC1, cv::Scalar(255));
  valid.at<std::uint8_t>(40, 100) = 0;
  const auto picture = make_station_picture(room.room(), {0, 2}, kPictureSize, {}, valid);
  int invalid = 0;
  for (const MatchingSample sample : picture.samples) {
    invalid += channel_of(sample, 3) == static_cast<int>(kInvalidDetail) ? 1 : 0;
  }
  EXPECT_EQ(invalid, 4);
  for (const int su : {200, 201}) {
    for (const int sv : {80, 81}) {
      EXPECT_EQ(channel_of(picture.samples[static_cast<size_t>(su * 128 + sv)], 3), 0);
    }
  }
}

}  // namespace
}  // namespace raywalk::build_lf
