#include "calibrate/poses/solve_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "calibrate/poses/colmap_program.h"
#include "calibrate/poses/poses_report.h"
#include "calibrate/poses/test_rail_scene.h"
#include "capture/simulated/virtual_room/test_rooms.h"
#include "capture/simulated/virtual_room/virtual_room.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/report/markup_check.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

bool has_colmap() {
  try {
    ColmapProgram::find();
    return true;
  } catch (const Error&) {
    return false;
  }
}

// Two lines of four stations that cross at a corner of the room's cell, between the second and the
// third of each.
CaptureSet corner_set() {
  CaptureSet set;
  set.source = "corner";
  set.frame = {512, 256};
  add_test_line(&set, "x0", LineAxis::kX, 0.0, 0.3, 4);
  add_test_line(&set, "z0", LineAxis::kZ, 0.0, 0.3, 4);
  for (CaptureLine& line : set.lines) line.across_m = -0.5;
  for (CaptureFrame& frame : set.frames) frame.nominal_m += Eigen::Vector3d(-0.5, 0.0, -0.5);
  return set;
}

FramePoses corner_truth() { return test_truth(corner_set(), {0.01, 1.0, 0.001, 0.1}, 3); }

// Ray-traced from the true poses, once for all tests.
const std::vector<cv::Mat>& corner_pictures() {
  static const std::vector<cv::Mat> pictures = [] {
    const capture::VirtualRoom room(capture::furnished_room(5));
    std::vector<cv::Mat> rendered;
    for (const auto& pose : corner_truth()) {
      const Attitude attitude = attitude_from_world_from_camera(pose->world_from_camera);
      rendered.push_back(room.panorama({pose->position_m, attitude}, corner_set().frame,
                                       capture::Sampling::kFine));
    }
    return rendered;
  }();
  return pictures;
}

// Writes the pictures of the set; `change` may modify each of them.
template <typename Change>
CaptureSet captured(const std::filesystem::path& directory, const Change& change) {
  CaptureSet set = corner_set();
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    cv::Mat picture = corner_pictures()[i].clone();
    change(static_cast<int>(i), &picture);
    set.frames[i].file = directory / (set.frames[i].name + ".png");
    cv::imwrite(set.frames[i].file.string(), picture);
  }
  return set;
}

PosesOptions options_in(const TestDirectory& directory) {
  PosesOptions options;
  options.out = directory / "out";
  options.face_px = 256;
  options.threads = 2;
  return options;
}

// Error of the relative pose of two stations, in the first one's frame.
PoseDifference relative_error(const FramePoses& poses, const FramePoses& truth, int from, int to) {
  const auto relative = [&](const FramePoses& of) {
    const FramePose& a = *of[static_cast<std::size_t>(from)];
    const FramePose& b = *of[static_cast<std::size_t>(to)];
    return std::pair(
        Eigen::Vector3d(a.world_from_camera.transpose() * (b.position_m - a.position_m)),
        Eigen::Matrix3d(a.world_from_camera.transpose() * b.world_from_camera));
  };
  const auto [position, rotation] = relative(poses);
  const auto [true_position, true_rotation] = relative(truth);
  return {(position - true_position).norm(), angle_between(rotation, true_rotation)};
}

class SolvePoses : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_colmap()) GTEST_SKIP() << "COLMAP is not installed";
  }
};

TEST_F(SolvePoses, RecoversHowTwoRailsCross) {
  const TestDirectory directory;
  const FramePoses truth = corner_truth();
  // One picture does not show the room.
  const CaptureSet set = captured(directory.path(), [](int frame, cv::Mat* picture) {
    if (frame == 3) cv::randu(*picture, 0, 255);
  });
  testing::internal::CaptureStderr();
  const PosesResult result = solve_poses(set, options_in(directory));
  // All that takes long shows how far it is.
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(ContainsRegex("matching features: [0-9]+ of [0-9]+ pairs \\(100 %\\)"),
                    ContainsRegex("triangulating: [0-9]+ of [0-9]+ faces"),
                    HasSubstr("adjusting poses: 63 of 63 steps (100 %)")));
  // Stations 1 and 5 are at the crossing.
  const PoseDifference error = relative_error(result.poses, truth, 1, 5);
  EXPECT_LT(error.position_m, 0.5e-3);
  EXPECT_LT(error.rotation_rad * kResidualPx_per_rad, 0.5);
  EXPECT_GT(relative_error(nominal_poses(set), truth, 1, 5).position_m, 2e-3);
  EXPECT_EQ(std::count(result.poses.begin(), result.poses.end(), std::nullopt), 1);
  ASSERT_EQ(result.unposed.size(), 1U);
  EXPECT_EQ(result.unposed[0].frame, 3);
  EXPECT_THAT(result.warnings, Contains(HasSubstr("line x0: 1 of 4 stations have no pose")));
  ASSERT_EQ(result.crossings.size(), 1U);
  EXPECT_GT(result.crossings[0].points, 50);

  const auto json = nlohmann::json::parse(read_file(directory / "out/poses-report.json"));
  EXPECT_EQ(json["posed"], 7);
  EXPECT_EQ(json["unposed"][0]["name"], "x0_3");
  EXPECT_EQ(markup_fault(read_file(directory / "out/poses.html")), "");
  const FramePoses read = read_frame_poses(directory / "out/poses.json", set);
  EXPECT_LT(largest_difference(read, result.poses).position_m, 1e-9);

  // A second run matches nothing again.
  const PosesResult again = solve_poses(set, options_in(directory));
  const auto reused = std::count_if(again.times.begin(), again.times.end(),
                                    [](const StepTime& time) { return time.reused; });
  EXPECT_EQ(reused, 3);
  EXPECT_LT(relative_error(again.poses, truth, 1, 5).position_m, 0.5e-3);
}

TEST_F(SolvePoses, ReportsAMirroredCamera) {
  const TestDirectory directory;
  const CaptureSet set = captured(directory.path(), [](int /*frame*/, cv::Mat* picture) {
    cv::flip(picture->clone(), *picture, 1);
  });
  try {
    solve_poses(set, options_in(directory));
    FAIL() << "solved";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("corner"), HasSubstr("mirrored")));
  }
  EXPECT_FALSE(std::filesystem::exists(directory / "out/poses.json"));
  EXPECT_THAT(read_file(directory / "out/poses-report.json"), HasSubstr("mirrored"));
}

TEST_F(SolvePoses, ReportsPicturesWithoutFeatures) {
  const TestDirectory directory;
  const CaptureSet set = captured(directory.path(), [](int /*frame*/, cv::Mat* picture) {
    picture->setTo(cv::Scalar(90, 90, 90));
  });
  try {
    solve_poses(set, options_in(directory));
    FAIL() << "solved";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("no pose could be solved"), HasSubstr("too plain")));
  }
  const auto json = nlohmann::json::parse(read_file(directory / "out/poses-report.json"));
  EXPECT_EQ(json["unposed"].size(), 8U);
  EXPECT_THAT(json["unposed"][0]["reason"], HasSubstr("only 0 features"));
}

TEST(SolvePosesInput, IsChecked) {
  const TestDirectory directory;
  CaptureSet set = corner_set();
  PosesOptions options = options_in(directory);
  const auto refusal = [&]() -> std::string {
    try {
      solve_poses(set, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  options.face_px = 8;
  EXPECT_THAT(refusal(), HasSubstr("a face's side is 8 px"));
  options.face_px = 0;
  options.keyframes_mm = -1.0;
  EXPECT_THAT(refusal(), HasSubstr("distance of keyframes"));
  options.keyframes_mm = 0.0;
  options.start.resize(3);
  EXPECT_THAT(refusal(), HasSubstr("3 poses to start from, but 8 stations"));
  options.start.clear();
  options.mask = cv::Mat(10, 20, CV_8UC1);
  EXPECT_THAT(refusal(), HasSubstr("the mask is 20x10"));
  options.mask.reset();
  set.layout = FrameLayout::kDualFisheye;
  EXPECT_THAT(refusal(), HasSubstr("run raywalk-calibrate stitch first"));
}

// COLMAP would abort.
TEST(SolvePosesInput, NeedsThreeStations) {
  const TestDirectory directory;
  CaptureSet set;
  set.source = "pair";
  set.frame = {512, 256};
  add_test_line(&set, "x0", LineAxis::kX, 0.0, 0.3, 2);
  try {
    solve_poses(set, options_in(directory));
    FAIL() << "solved";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("pair: 2 of its 2 stations"), HasSubstr("more")));
  }
}

TEST(SolvePosesInput, NeedsColmap) {
  const TestDirectory directory;
  const std::string path = std::getenv("PATH");
  setenv("PATH", directory.path().c_str(), 1);
  try {
    solve_poses(corner_set(), options_in(directory));
    ADD_FAILURE() << "solved";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no COLMAP found"));
  }
  setenv("PATH", path.c_str(), 1);
}

}  // namespace
}  // namespace raywalk::calibrate
