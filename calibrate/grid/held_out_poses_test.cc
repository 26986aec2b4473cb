#include "calibrate/grid/held_out_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/grid/estimate_grid.h"
#include "calibrate/grid/test_grid.h"
#include "calibrate/grid/test_room.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using testing::HasSubstr;

void add_held_out(CaptureSet* set, const std::string& name, const Eigen::Vector3d& nominal_m) {
  set->frames.push_back({.name = name, .line = kHeldOut, .nominal_m = nominal_m});
}

// The grid corrects the solved poses of line x0 by some millimetres and degrees, the others not.
TEST(HeldOutPosesTest, AreCorrectedAsTheStationsNearThem) {
  TestGrid grid = TestGridMaker({.stations = 21, .matches = 1}, 3).make();
  CaptureSet set = grid.set;
  FramePoses solved = nominal_poses(set);
  const Eigen::Vector3d moved(0.004, -0.002, 0.003), turned(0.01, 0.02, -0.005);
  GridResult result{.poses = solved};
  for (const int frame : set.lines[0].frames) {
    FramePose& pose = *result.poses[static_cast<size_t>(frame)];
    pose.position_m += moved;
    pose.world_from_camera = matrix_of(turned) * pose.world_from_camera;
  }
  result.lines.resize(set.lines.size());
  // An outlier is no correction.
  result.lines[0].rejected_frames = {10};
  result.poses[10]->position_m += Eigen::Vector3d(1.0, 1.0, 1.0);
  const Eigen::Vector3d near = set.frames[10].nominal_m + Eigen::Vector3d(0.01, 0.0, 0.02);
  add_held_out(&set, "near", near);
  add_held_out(&set, "unsolved", near);
  add_held_out(&set, "between", {0.0, 0.0, 0.0});
  for (const Eigen::Vector3d& at : {near, near, Eigen::Vector3d(0.0, 0.0, 0.0)}) {
    solved.emplace_back(FramePose{.position_m = at, .origin = PoseOrigin::kSolved});
  }
  solved[solved.size() - 2].reset();
  const FramePoses poses = held_out_poses(set, solved, result);
  ASSERT_EQ(poses.size(), 3U);
  ASSERT_TRUE(poses[0]);
  // A few centimetres from x0, half a metre from the next line.
  EXPECT_LT((poses[0]->position_m - near - moved).norm(), 0.25 * moved.norm());
  EXPECT_LT((vector_of(poses[0]->world_from_camera) - turned).norm(), 0.25 * turned.norm());
  EXPECT_EQ(poses[0]->origin, PoseOrigin::kSolved);
  EXPECT_FALSE(poses[1]);
  // As far from all four lines: a quarter.
  EXPECT_LT((poses[2]->position_m - 0.25 * moved).norm(), 0.1 * moved.norm());
}

TEST(HeldOutPosesTest, LinesAreAsWithoutThem) {
  const TestDirectory directory;
  const RoomCapture capture = capture_room(directory.path(), {});
  const GridOptions alone{.method = GridMethod::kPoses, .out = directory / "alone"};
  estimate_grid(capture.set, capture.truth, alone);
  CaptureSet set = capture.set;
  FramePoses solved = capture.truth;
  add_held_out(&set, "solved", {3.0, 1.0, 2.0});
  add_held_out(&set, "unsolved", {0.1, 0.1, 0.1});
  solved.emplace_back(FramePose{.position_m = {5.0, -4.0, 3.0}, .origin = PoseOrigin::kSolved});
  solved.emplace_back(std::nullopt);
  const GridOptions with{.method = GridMethod::kPoses, .out = directory / "with"};
  const GridResult result = estimate_grid(set, solved, with);
  ASSERT_FALSE(result.notes.empty());
  EXPECT_THAT(result.notes.back(), HasSubstr("left out of gt.csv: unsolved"));
  const FramePoses read = read_frame_poses(directory / "with/grid.json", set);
  ASSERT_EQ(read.size(), set.frames.size());
  EXPECT_TRUE(read[set.frames.size() - 2]);
  EXPECT_FALSE(read.back());
  const FramePoses stations = read_frame_poses(directory / "alone/grid.json", capture.set);
  for (size_t i = 0; i < stations.size(); ++i) {
    EXPECT_EQ(read[i]->position_m, stations[i]->position_m);
  }
}

}  // namespace
}  // namespace raywalk::calibrate
