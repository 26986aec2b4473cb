#include "render/view/view_video.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "render/video/test_video.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

cv::Mat grey(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

class ViewVideoTest : public ::testing::Test {
 protected:
  ViewVideoTest() {
    write_synthetic_room({.width = 128}, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
    std::ofstream(request_.table) << "name,x,z,yaw\na,0,0,0\nb,0.25,-0.25,40\nc,0.3,0.1,90\n";
  }
  std::string video(const ViewFrame& frame, const VideoSettings& settings = {.fps = 10}) const {
    return write_video(room_, mode_, frame, request_, settings, directory_ / "walk.mp4");
  }
  // The frames of the video beside the stills of the same request.
  void compare_with_stills(const ViewFrame& frame, cv::Size size) const {
    write_path(room_, mode_, frame, request_, {}, directory_ / "stills");
    const std::vector<cv::Mat> frames = video_frames(directory_ / "walk.mp4", size);
    ASSERT_EQ(frames.size(), 8U);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const std::string name = "path-0000" + std::to_string(i + 1) + ".png";
      // Videos have half the resolution of colours; video_writer_test compares those.
      const cv::Mat still = read_picture(directory_ / "stills" / name);
      EXPECT_GT(cv::PSNR(grey(frames[i]), grey(still)), 35.0) << name;
    }
  }

  TestDirectory directory_;
  Room room_;
  ViewMode mode_{.options = {.k_deg = 80.0}, .k_source = "given"};
  PathRequest request_{.table = directory_ / "path.csv",
                       .movement = SmoothMovement{.fps = 10, .seconds = 0.8}};
};

TEST_F(ViewVideoTest, ShowsWhatStillsShow) {
  EXPECT_THAT(video({}), AllOf(HasSubstr("walk.mp4: 8 frames of 128x64, 0.8 s, H.264, crf 18"),
                               HasSubstr("a panorama"), HasSubstr("distances given")));
  const auto stream = video_stream(directory_ / "walk.mp4");
  EXPECT_EQ(side_data(stream, "Spherical Mapping")["projection"], "equirectangular");
  compare_with_stills({}, {128, 64});
}

TEST_F(ViewVideoTest, VideosForTwoEyesSaySo) {
  const ViewFrame both{.stereo = Stereo::kOds};
  EXPECT_THAT(video(both), HasSubstr("8 frames of 128x128, 0.8 s, H.264, crf 18, a panorama, ods"));
  const auto stream = video_stream(directory_ / "walk.mp4");
  EXPECT_EQ(side_data(stream, "Spherical Mapping")["projection"], "equirectangular");
  EXPECT_EQ(side_data(stream, "Stereo 3D")["type"], "top and bottom");
  compare_with_stills(both, {128, 128});
}

TEST_F(ViewVideoTest, FlatVideosSayNothingOfASphere) {
  const ViewFrame flat{.fov_deg = 80.0, .size = "96x64"};
  EXPECT_THAT(video(flat), HasSubstr("8 frames of 96x64, 0.8 s, H.264, crf 18, flat"));
  EXPECT_TRUE(side_data(video_stream(directory_ / "walk.mp4"), "Spherical Mapping").empty());
  compare_with_stills(flat, {96, 64});
}

TEST_F(ViewVideoTest, WhatCannotBeAVideoIsRefusedBeforeAnyWork) {
  EXPECT_THAT(error_of([&] { video({.fov_deg = 80.0, .size = "95x64"}); }), HasSubstr("even"));
  // Between places that can be rendered the curve leaves the cell.
  std::ofstream(request_.table) << "name,x,z\na,0.499,-0.4\nb,0.499,0.499\nc,-0.4,0.499\n";
  EXPECT_THAT(error_of([&] { video({}); }),
              AllOf(HasSubstr("path.csv: view 'path-0000"), HasSubstr("between '"),
                    HasSubstr("outside every cell")));
  EXPECT_EQ(directory_.entries(), 2U);
}

}  // namespace
}  // namespace raywalk::render
