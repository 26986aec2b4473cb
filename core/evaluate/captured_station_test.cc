#include "core/evaluate/captured_station.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

class CapturedStationTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, directory_ / "room.lf");
    return Room::open(directory_ / "room.lf");
  }

  TestDirectory directory_;
};

TEST_F(CapturedStationTest, PictureIsTheCapturedFrame) {
  const SyntheticRoomSpec spec{.cells_z = 0, .width = 64};
  const Room room = room_of(spec);
  const Eigen::Vector3d& at_m = room.grid().lines[0].stations[3].position_m;
  const cv::Mat picture = captured_picture(room.volume(0), 3);
  EXPECT_EQ(cv::norm(picture, render_truth(spec, {at_m.x(), at_m.z()}, 64), cv::NORM_INF), 0.0);
  EXPECT_TRUE(captured_mask(room.volume(0), 3).empty());
}

TEST_F(CapturedStationTest, SampledPixelsAreThoseOfTheWholePicture) {
  SyntheticRoomSpec spec{.cells_z = 0, .width = 64};
  spec.companion = CameraCompanion{
      .hides = [](const std::string&, int, const Eigen::Vector3d& d) { return d.y() < -0.3; }};
  const Room room = room_of(spec);
  const cv::Mat picture = captured_picture(room.volume(0), 2);
  const cv::Mat mask = captured_mask(room.volume(0), 2);
  for (const int stride : {1, 2, 3, 5}) {
    const SampledPixels pixels{room.panorama(), stride};
    const cv::Mat columns = captured_columns(room.volume(0), 2, pixels);
    const cv::Mat valid = valid_columns(room.volume(0), 2, pixels);
    ASSERT_EQ(columns.size(), cv::Size(pixels.rows(), pixels.columns()));
    EXPECT_LT(pixels.at(pixels.columns() - 1), 64);
    EXPECT_GE(pixels.at(pixels.columns()), 64) << "none is left out, stride " << stride;
    for (int i = 0; i < pixels.columns(); ++i) {
      for (int j = 0; j < pixels.rows(); ++j) {
        const cv::Vec3b bgr = picture.at<cv::Vec3b>(pixels.at(j), pixels.at(i));
        ASSERT_EQ(columns.at<cv::Vec3b>(i, j), cv::Vec3b(bgr[2], bgr[1], bgr[0]));
        ASSERT_EQ(valid.at<std::uint8_t>(i, j), mask.at<std::uint8_t>(pixels.at(j), pixels.at(i)));
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
