#include "calibrate/base/frame_poses.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "calibrate/base/frame_masks.h"
#include "calibrate/base/test_capture_folder.h"
#include "core/files/json.h"
#include "core/files/test_support.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class FramePosesTest : public ::testing::Test {
 protected:
  FramePosesTest() {
    folder_.write_cross();
    set_ = folder_.read();
  }
  void write(const std::string& file, const FramePoses& poses) const {
    const nlohmann::ordered_json document{{"format_version", 1},
                                          {"frames", frame_poses_json(set_, poses)}};
    write_file_atomically(folder_ / file, json_text(document));
  }
  std::string read_error(const std::string& text) const {
    write_file_atomically(folder_ / "poses.json", text);
    return error_of([&] { read_frame_poses(folder_ / "poses.json", set_); });
  }
  std::string table_error(const std::string& rows,
                          const std::string& columns = "file,x,y,z,yaw,pitch,roll") const {
    write_file_atomically(folder_ / "true.csv", columns + "\n" + rows);
    return error_of([&] { read_pose_table(folder_ / "true.csv", set_); });
  }

  TestCaptureFolder folder_;
  CaptureSet set_;
};

TEST_F(FramePosesTest, ReadsWhatItWrote) {
  FramePoses poses(set_.frames.size());
  poses[1] = FramePose{.position_m = {1.0 / 3.0, -2e-9, 1e5},
                       .world_from_camera = world_from_camera({3.0, -1.2, -2.9}),
                       .origin = PoseOrigin::kRail,
                       .position_sigma_mm = 0.125,
                       .rotation_sigma_deg = 0.01,
                       .observations = 77,
                       .residual_px = 0.4};
  poses[4] = FramePose{.origin = PoseOrigin::kGiven};
  write("poses.json", poses);
  const FramePoses read = read_frame_poses(folder_ / "poses.json", set_);
  ASSERT_EQ(read.size(), poses.size());
  for (const std::size_t i : {0U, 2U, 3U, 5U}) EXPECT_FALSE(read[i]);
  ASSERT_TRUE(read[1] && read[4]);
  EXPECT_EQ(read[1]->position_m, poses[1]->position_m);
  EXPECT_LT(angle_between(read[1]->world_from_camera, poses[1]->world_from_camera), 1e-12);
  EXPECT_EQ(read[1]->origin, PoseOrigin::kRail);
  EXPECT_EQ(read[1]->position_sigma_mm, 0.125);
  EXPECT_EQ(read[1]->rotation_sigma_deg, 0.01);
  EXPECT_EQ(read[1]->observations, 77);
  EXPECT_EQ(read[1]->residual_px, 0.4);
  EXPECT_EQ(read[4]->origin, PoseOrigin::kGiven);
}

TEST_F(FramePosesTest, DamagedFilesAreNamed) {
  write("good.json", nominal_poses(set_));
  const std::string good = read_file(folder_ / "good.json");
  const auto replaced = [&](const std::string& what, const std::string& by) {
    std::string text = good;
    text.replace(text.find(what), what.size(), by);
    return read_error(text);
  };
  EXPECT_EQ(read_error(good), "no error");
  EXPECT_THAT(read_error(good.substr(0, good.size() / 2)),
              AllOf(HasSubstr("poses.json"), HasSubstr("damaged")));
  EXPECT_THAT(replaced("\"format_version\": 1", "\"format_version\": 2"), HasSubstr("newer"));
  EXPECT_THAT(replaced("\"position_m\": [", "\"position_m\": [1e308, 0, 0], \"p\": ["),
              HasSubstr("position_m[0]: 1e+308 is not between"));
  EXPECT_THAT(replaced("\"a0\"", "\"zz\""), HasSubstr("frame 'zz' is not in the capture"));
  EXPECT_THAT(replaced("\"a0\"", "\"a1\""), HasSubstr("twice"));
  EXPECT_THAT(replaced("\"nominal\"", "\"guessed\""), HasSubstr("'guessed'"));
  EXPECT_THAT(replaced("\"yaw_deg\": ", "\"yaw_deg\": null, \"y\": "),
              HasSubstr("frames[0]: yaw_deg: null is not a number; solve the poses again"));
  EXPECT_THROW(read_frame_poses(folder_ / "none.json", set_), Error);
}

TEST_F(FramePosesTest, TableRowsAreMatchedByFileStem) {
  EXPECT_EQ(table_error("true/b1.jpg,1,2,3,10,20,30\nother.jpg,0,0,0,0,0,0\n"), "no error");
  const FramePoses poses = read_pose_table(folder_ / "true.csv", set_);
  const std::size_t at = indices_by_name(set_).at("b1");
  ASSERT_TRUE(poses[at]);
  EXPECT_EQ(poses[at]->position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_LT(angle_between(poses[at]->world_from_camera,
                          world_from_camera({radians_from_degrees(10), radians_from_degrees(20),
                                             radians_from_degrees(30)})),
            1e-12);
  EXPECT_EQ(poses[at]->origin, PoseOrigin::kGiven);
  EXPECT_EQ(std::count_if(poses.begin(), poses.end(), [](const auto& p) { return p.has_value(); }),
            1);
  EXPECT_THAT(table_error("q.jpg,0,0,0,0,0,0\n"),
              AllOf(HasSubstr("true.csv"), HasSubstr("none of the capture's frames")));
  EXPECT_THAT(table_error("a0.jpg,0,0,0\n", "file,x,y,z"), HasSubstr("yaw"));
  EXPECT_THAT(table_error("a0.jpg,1e308,0,0,0,0,0\n"),
              AllOf(HasSubstr("true.csv:2: x = 1e+308"), HasSubstr("not a position")));
  EXPECT_THAT(table_error("a0.jpg,0,0,0,0,-1e308,0\n"), HasSubstr("true.csv:2: pitch = -1e+308"));
  EXPECT_THAT(table_error("a0.jpg,0,0,0,0,0,abc\n"), HasSubstr("true.csv:2"));
}

// Exact for very small angles and near half a turn.
TEST(AngleBetweenTest, IsTheAngleOfTheRotation) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  const Eigen::Matrix3d start = world_from_camera({0.4, 1.1, -2.0});
  for (const double angle_rad : {0.0, 1e-14, 1e-9, 1e-4, 0.5, 2.0, kPi - 1e-9, kPi}) {
    const Eigen::Matrix3d turned = start * Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
    EXPECT_NEAR(angle_between(start, turned), angle_rad, 2e-15 + 1e-9 * angle_rad);
  }
}

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
  write_mask("b_mask.png", cv::Mat(8, 16, CV_8UC1, cv::Scalar(0)));
  refused("masks every pixel");
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
