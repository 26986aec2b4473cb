#include "calibrate/base/frame_masks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/base/test_capture_folder.h"
#include "core/base/test_error.h"
#include "core/base/test_log.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A line of three stations; the masks of the first two may be written.
class FrameMasksTest : public ::testing::Test {
 protected:
  FrameMasksTest() {
    for (const char* file : {"a.png", "b.png", "c.png", "t.png"}) folder_.add_picture(file);
    list("a.png,0,0,0,a_mask.png\nb.png,0.1,0,0,b_mask.png\nc.png,0.2,0,0,\n");
    for (const char* file : {"a_mask.png", "b_mask.png"}) write_mask(file, half());
  }
  void list(const std::string& rows) const { folder_.write_list(rows, "file,x,y,z,mask"); }
  void write_mask(const std::string& file, const cv::Mat& mask) const {
    write_image(folder_ / file, mask);
  }
  // The lower half is masked, the rest is 1, which counts as valid.
  static cv::Mat half() {
    cv::Mat mask(8, 16, CV_8UC1, cv::Scalar(1));
    mask.rowRange(4, 8).setTo(0);
    return mask;
  }

  TestCaptureFolder folder_;
};

TEST_F(FrameMasksTest, MasksOfTheListAreReadAndFramesWithoutOneCounted) {
  const CapturedLog log;
  const CaptureSet set = folder_.read();
  EXPECT_THAT(log.text(), AllOf(HasSubstr("1 of 3 frames have no mask"), HasSubstr("poses.csv:4")));
  ASSERT_TRUE(any_masks(set));
  const cv::Mat mask = joint_mask(set, 0, {});
  EXPECT_EQ(mask.at<uchar>(3, 5), 255);
  EXPECT_EQ(mask.at<uchar>(4, 5), 0);
  EXPECT_TRUE(joint_mask(set, 2, {}).empty());
}

TEST_F(FrameMasksTest, MaskOfAllFramesIsJoined) {
  const CaptureSet set = folder_.read();
  cv::Mat common(8, 16, CV_8UC1, cv::Scalar(255));
  common.colRange(0, 8).setTo(0);
  const cv::Mat joint = joint_mask(set, 1, common);
  EXPECT_EQ(cv::countNonZero(joint), 4 * 8);
  EXPECT_EQ(joint.at<uchar>(0, 0), 0);
  EXPECT_EQ(joint.at<uchar>(7, 15), 0);
  EXPECT_EQ(joint.at<uchar>(0, 15), 255);
  EXPECT_EQ(cv::norm(joint_mask(set, 2, common), common, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::countNonZero(common), 8 * 8);  // is left as it was
  const MaskFigures figures = mask_figures(set, common);
  EXPECT_EQ(figures.frames, 2);
  EXPECT_NEAR(figures.share, 0.75, 0.02);
  common.setTo(255);
  common.rowRange(0, 4).setTo(0);
  EXPECT_THAT(error_of([&] { joint_mask(set, 0, common); }),
              AllOf(HasSubstr("poses.csv:2: "), HasSubstr("a_mask.png"),
                    HasSubstr("hide every pixel of frame a")));
}

TEST_F(FrameMasksTest, UnusableMasksAreNamedWithTheirRow) {
  const auto refused = [&](const std::string& why) {
    EXPECT_THAT(folder_.read_error(),
                AllOf(HasSubstr("poses.csv:3: "), HasSubstr("b_mask.png"), HasSubstr(why)));
  };
  write_mask("b_mask.png", cv::Mat(16, 32, CV_8UC1, cv::Scalar(255)));
  refused("the mask is 32x16, but 16x8 is needed");
  write_mask("b_mask.png", cv::Mat(8, 16, CV_8UC3, cv::Scalar::all(255)));
  refused("not an 8-bit grey image");
  write_mask("b_mask.png", cv::Mat(8, 16, CV_8UC1, cv::Scalar(0)));
  refused("masks every pixel");
  write_mask("b_mask.png", half());
  const std::string good = read_file(folder_ / "b_mask.png");
  write_file_atomically(folder_ / "b_mask.png", good.substr(0, good.size() / 2));
  refused("cut short");
  write_file_atomically(folder_ / "b_mask.png", std::string("no picture"));
  refused("");
  std::filesystem::remove(folder_ / "b_mask.png");
  refused("does not exist");
}

TEST_F(FrameMasksTest, MasksOfHeldOutFramesAreCheckedAlike) {
  write_file_atomically(folder_ / "gt.csv",
                        std::string("file,x,y,z,mask\nt.png,0,0,0,t_mask.png\n"));
  EXPECT_THAT(folder_.read_error(), AllOf(HasSubstr("gt.csv:2: "), HasSubstr("t_mask.png")));
  write_mask("t_mask.png", half());
  EXPECT_EQ(cv::countNonZero(joint_mask(folder_.read(), 3, {})), 4 * 16);
}

}  // namespace
}  // namespace raywalk::calibrate
