#include "render/view/view_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "core/view/test_room.h"

namespace raywalk::render {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

TEST(ViewFrame, IsAPanoramaUnlessItHasAFieldOfView) {
  EXPECT_FALSE(viewport_of({}));
  EXPECT_FALSE(viewport_of({.yaw_deg = 30.0}));
  const auto viewport = viewport_of({.yaw_deg = 30.0, .pitch_deg = -5.0, .fov_deg = 90.0});
  ASSERT_TRUE(viewport);
  EXPECT_DOUBLE_EQ(viewport->attitude.yaw_rad, radians_from_degrees(30.0));
  EXPECT_DOUBLE_EQ(viewport->attitude.pitch_rad, radians_from_degrees(-5.0));
  EXPECT_DOUBLE_EQ(viewport->fov_x_rad, kHalfPi);
  EXPECT_EQ(viewport->width, 1280);
  EXPECT_EQ(viewport->height, 720);
  EXPECT_EQ(viewport_of({.fov_deg = 60.0, .size = "1440x1600"})->height, 1600);
}

TEST(ViewFrame, RejectsMalformedSizes) {
  for (const char* size : {"1440", "x", "1440x", "x20", "1440x1600x3", "axb", "4.5x2"}) {
    EXPECT_THAT([&] { viewport_of({.fov_deg = 90.0, .size = size}); },
                ThrowsMessage<UsageError>(HasSubstr("WIDTHxHEIGHT")))
        << size;
  }
  EXPECT_THAT([] { viewport_of({.fov_deg = 90.0, .size = "-4x100"}); },
              ThrowsMessage<UsageError>(HasSubstr("1 to 16384")));
  EXPECT_THAT([] { viewport_of({.size = "100x100"}); },
              ThrowsMessage<UsageError>(HasSubstr("--fov-deg")));
  EXPECT_THROW(viewport_of({.yaw_deg = std::nan("")}), UsageError);
}

TEST(ViewFrame, TwoEyesSeePanoramasThatAreTurnedInThePlanOnly) {
  EXPECT_FALSE(viewport_of({.yaw_deg = 30.0, .stereo = Stereo::kOds, .ipd_mm = 200.0}));
  EXPECT_EQ(ipd_mm_of({.stereo = Stereo::kOds}), 63.0);
  for (const ViewFrame& frame :
       {ViewFrame{.fov_deg = 90.0, .stereo = Stereo::kOds},
        ViewFrame{.pitch_deg = 1.0, .stereo = Stereo::kOds},
        ViewFrame{.roll_deg = 1.0, .stereo = Stereo::kOds},
        ViewFrame{.stereo = Stereo::kOds, .ipd_mm = 0.9},
        ViewFrame{.stereo = Stereo::kOds, .ipd_mm = 201.0},
        ViewFrame{.stereo = Stereo::kOds, .ipd_mm = std::nan("")}, ViewFrame{.ipd_mm = 63.0}}) {
    EXPECT_THROW(viewport_of(frame), UsageError);
  }
}

TEST(ViewFrame, EnlargementIsThatOfTheMiddle) {
  // 720 pixels per tangent of one, against 512 pixels per turn.
  EXPECT_NEAR(enlargement_of({.fov_deg = 90.0, .size = "1440x1600"}, 1440, 512),
              720.0 / (512.0 / kTwoPi), 1e-9);
  EXPECT_EQ(enlargement_of({}, 1024, 512), 2.0);
  EXPECT_EQ(enlargement_of({.yaw_deg = 30.0}, 512, 512), 1.0);
  EXPECT_EQ(enlargement_text(8.836, 512), "enlarged 8.8 times from panoramas 512 pixels wide");
  EXPECT_EQ(enlargement_text(17.67, 512), "enlarged 18 times from panoramas 512 pixels wide");
  EXPECT_EQ(enlargement_text(1.0, 512), "");
  EXPECT_EQ(enlargement_text(0.3, 4096), "");
}

class WriteView : public testing::Test {
 protected:
  cv::Mat written(const ViewFrame& frame) {
    told_ = write_view(room_.room(), {.options = {.k_deg = 76.0}, .k_source = "given"}, {0.1, -0.2},
                       frame, directory_ / "view.png");
    return read_picture(directory_ / "view.png");
  }
  TestDirectory directory_;
  TestRoom room_{box_room(128)};
  std::string told_;
};

TEST_F(WriteView, TurnsAPanorama) {
  const cv::Mat straight = written({});
  ASSERT_EQ(straight.size(), cv::Size(128, 64));
  // A quarter to the right: what was a quarter right of the middle is in the middle.
  const cv::Mat turned = written({.yaw_deg = 90.0});
  for (int u = 0; u < 96; ++u) {
    EXPECT_LE(cv::norm(turned.col(u), straight.col(u + 32), cv::NORM_INF), 1.0);
  }
  // Upside down.
  const cv::Mat over = written({.roll_deg = 180.0});
  cv::Mat flipped;
  cv::flip(straight, flipped, -1);
  EXPECT_LE(cv::norm(over, flipped, cv::NORM_INF), 1.0);
}

TEST_F(WriteView, ReplacesViewsButNothingElse) {
  written({});
  EXPECT_NO_THROW(written({.fov_deg = 80.0, .size = "32x32"}));
  EXPECT_NO_THROW(written({}));
  write_image(directory_ / "view.png", cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3)));
  EXPECT_THAT([&] { written({}); }, ThrowsMessage<Error>(HasSubstr("is no view made by Raywalk")));
  EXPECT_EQ(read_picture(directory_ / "view.png").size(), cv::Size(8, 8));
}

TEST_F(WriteView, TurnsThePanoramasOfBothEyes) {
  const cv::Mat straight = written({.stereo = Stereo::kOds});
  ASSERT_EQ(straight.size(), cv::Size(128, 128));
  EXPECT_GT(cv::norm(straight.rowRange(0, 64), straight.rowRange(64, 128), cv::NORM_INF), 1.0);
  const cv::Mat turned = written({.yaw_deg = 90.0, .stereo = Stereo::kOds});
  for (int u = 0; u < 96; ++u) {
    EXPECT_LE(cv::norm(turned.col(u), straight.col(u + 32), cv::NORM_INF), 1.0);
  }
}

TEST_F(WriteView, WritesAFlatPictureInItsDirection) {
  const cv::Mat straight = written({});
  const cv::Mat picture = written({.yaw_deg = -90.0, .fov_deg = 40.0, .size = "65x33"});
  EXPECT_EQ(picture.size(), cv::Size(65, 33));
  EXPECT_THAT(told_, HasSubstr("65x33, enlarged 4.4 times from panoramas 128 pixels wide, at 0.1"));
  written({.fov_deg = 120.0, .size = "32x32"});
  EXPECT_THAT(told_, Not(HasSubstr("enlarged")));
  const cv::Vec3b middle = picture.at<cv::Vec3b>(16, 32);
  const cv::Vec3b left = straight.at<cv::Vec3b>(32, 32);
  EXPECT_LE(cv::norm(cv::Vec3d(middle) - cv::Vec3d(left)), 12.0);
}

}  // namespace
}  // namespace raywalk::render
