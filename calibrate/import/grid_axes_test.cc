#include "calibrate/import/grid_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/import/test_poses.h"
#include "core/base/test_error.h"

namespace raywalk::calibrate {
namespace {

using ::testing::HasSubstr;

ImportedPoses turned_square(const Attitude& turn, double scale) {
  return {.kind = "a test",
          .frames = in_other_axes(square_frames(), world_from_camera(turn), {3, -2, 5}, scale)};
}

void expect_frames(const std::vector<ImportedFrame>& truth, const ImportedPoses& poses,
                   const GridAxes& axes, double tolerance) {
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const CameraPose pose = moved(axes, poses.frames[i].pose);
    EXPECT_LT((pose.position_m - truth[i].pose.position_m).norm(), tolerance) << i;
    EXPECT_LT((pose.world_from_camera - truth[i].pose.world_from_camera).norm(), tolerance) << i;
  }
}

TEST(GridAxes, UndoAnyRotationAndScale) {
  for (const Attitude turn :
       {Attitude{0.3, 0, 0}, {2.5, 1.2, -0.7}, {-1.7, -0.4, 3.0}, {0.78, 0, 0}}) {
    for (const double scale : {0.13, 4.0}) {
      const ImportedPoses poses = turned_square(turn, scale);
      expect_frames(square_frames(), poses, fit_grid_axes(poses, {.scale = {.cell_m = 1.0}}), 1e-9);
      expect_frames(square_frames(), poses, fit_grid_axes(poses, {.scale = {.spacing_m = 0.25}}),
                    1e-9);
      expect_frames(square_frames(), poses,
                    fit_grid_axes(poses, {.scale = {.metres_per_unit = scale}}), 1e-9);
      expect_frames(
          square_frames(), poses,
          fit_grid_axes(poses, {.scale = {.distance = KnownDistance{"00", "04.jpg", 1.0}}}), 1e-9);
    }
  }
}

TEST(GridAxes, AreKeptIfAskedFor) {
  ImportedPoses poses = turned_square({0, 0, 0}, 2.0);
  const GridAxes axes = fit_grid_axes(poses, {.fit = false, .scale = {.metres_per_unit = 2.0}});
  EXPECT_EQ(axes.rotation, Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  EXPECT_EQ(moved(axes, poses.frames[0].pose).position_m, Eigen::Vector3d(2.25, -2, 5.5));
}

TEST(GridAxes, OfAnUprightSourceTurnAboutTheVerticalOnly) {
  ImportedPoses poses = turned_square({0.4, 0, 0}, 1.0);
  // A street that falls: level lines would lean the cameras.
  for (ImportedFrame& frame : poses.frames)
    frame.pose.position_m.y() -= 0.05 * frame.pose.position_m.x();
  poses.in_world = true;
  const GridAxes axes = fit_grid_axes(poses, {});
  EXPECT_LT((axes.rotation.col(1) - Eigen::Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_EQ(axes.scale, 1.0);
}

// A single line has no plane: its cameras tell what is up, and it becomes level.
TEST(GridAxes, OfOneLineStandOnTheCameras) {
  std::vector<ImportedFrame> line;
  for (int i = 0; i < 7; ++i) {
    line.push_back(
        {.file = std::to_string(i), .pose = {{0.1 * i - 0.3, 0, 0}, world_from_camera({0, 0, 0})}});
  }
  const ImportedPoses poses{
      .kind = "a test",
      .frames = in_other_axes(line, world_from_camera({2.0, 0.5, 0.9}), {1, 1, 1}, 1.0)};
  expect_frames(line, poses, fit_grid_axes(poses, {.scale = {.metres_per_unit = 1.0}}), 1e-12);
}

TEST(GridAxes, StayRightWithStationsBesideTheirLines) {
  ImportedPoses poses = turned_square({1.1, 0.3, 0.2}, 0.5);
  for (std::size_t i = 0; i < poses.frames.size(); ++i) {
    const double off = 0.02 * std::sin(7.0 * static_cast<double>(i));
    poses.frames[i].pose.position_m += Eigen::Vector3d(off, 0.5 * off, -off);
  }
  expect_frames(square_frames(), poses, fit_grid_axes(poses, {.scale = {.cell_m = 1.0}}), 0.03);
}

TEST(GridAxes, ThatCannotBeFoundAreSaid) {
  const auto error_for = [](const ImportedPoses& poses, const AxesOptions& options) {
    return error_of([&] { fit_grid_axes(poses, options); });
  };
  ImportedPoses poses = turned_square({0.1, 0.2, 0.3}, 1.0);
  EXPECT_THAT(error_for(poses, {.scale = {.distance = KnownDistance{"00", "nowhere", 1.0}}}),
              HasSubstr("'nowhere' is none of the 28 panoramas"));
  ImportedPoses line = poses;
  line.frames.resize(7);
  EXPECT_THAT(error_for(line, {.scale = {.cell_m = 1.0}}), HasSubstr("close no cell"));
  for (std::size_t i = 0; i < poses.frames.size(); ++i) {
    if (i % 2 == 0) poses.frames[i].pose.world_from_camera *= world_from_camera({0, 0, kPi});
  }
  EXPECT_THAT(error_for(poses, {.scale = {.cell_m = 1.0}}), HasSubstr("no common up"));
}

TEST(KnownPositions, GiveScaleAndAxes) {
  const ImportedPoses poses = turned_square({1.5, 0.4, -0.2}, 3.0);
  const std::vector<ImportedFrame> truth = square_frames();
  std::vector<KnownPosition> known;
  for (const std::size_t i : {0U, 3U, 9U, 20U}) known.push_back({i, truth[i].pose.position_m});
  expect_frames(square_frames(), poses, fit_known_positions(poses, known), 1e-12);
  known.resize(2);
  EXPECT_THAT(error_of([&] { fit_known_positions(poses, known); }), HasSubstr("at least three"));
  known = {
      {0, truth[0].pose.position_m}, {1, truth[1].pose.position_m}, {2, truth[2].pose.position_m}};
  EXPECT_THAT(error_of([&] { fit_known_positions(poses, known); }), HasSubstr("on one line"));
}

}  // namespace
}  // namespace raywalk::calibrate
