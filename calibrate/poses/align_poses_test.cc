#include "calibrate/poses/align_poses.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/poses/test_rail_scene.h"
#include "core/base/error.h"

namespace raywalk::calibrate {
namespace {

// The poses in another frame and scale.
FramePoses moved_away(const FramePoses& poses, double scale, unsigned seed) {
  std::mt19937 random(seed);
  PoseAlignment away;
  away.scale = scale;
  away.rotation = random_turn(&random, 170.0);
  away.translation_m = random_vector(&random, 5.0 * scale);
  return aligned(poses, away);
}

TEST(AlignPoses, UndoesAnySimilarityOfExactPosesAtAnySize) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    for (const double scale : {1e-4, 0.3, 1.0, 7e3}) {
      for (unsigned seed = 0; seed < 5; ++seed) {
        const CaptureSet set = test_grid(5, size);
        const FramePoses nominal = nominal_poses(set);
        const FramePoses solved = moved_away(nominal, scale, seed);
        const PoseAlignment alignment = align_poses(set, solved, nominal);
        EXPECT_NEAR(alignment.scale * scale, 1.0, 1e-9);
        EXPECT_EQ(alignment.rank, 2);
        const PoseDifference left = largest_difference(aligned(solved, alignment), nominal);
        EXPECT_LT(left.position_m, 1e-9 * size);
        EXPECT_LT(left.rotation_rad, 1e-6);  // acos near 1 keeps half the digits
      }
    }
  }
}

// Jitter makes a line not exactly straight, but contains no information about its roll: a
// similarity of the centres alone would fit the jitter.
TEST(AlignPoses, TakesTheRollOfASingleLineFromOrientations) {
  const CaptureSet set = test_line(30);
  const FramePoses nominal = nominal_poses(set);
  for (const bool jitter : {false, true}) {
    const FramePoses truth = jitter ? test_truth(set, {0, 0, 1e-3, 0.1}, 4) : nominal;
    const double tolerance_rad = jitter ? radians_from_degrees(0.1) : 1e-6;
    for (unsigned seed = 0; seed < 20; ++seed) {
      const FramePoses solved = moved_away(truth, 0.5, seed);
      const PoseAlignment alignment = align_poses(set, solved, nominal);
      EXPECT_EQ(alignment.rank, 1);
      EXPECT_LT(largest_difference(aligned(solved, alignment), truth).rotation_rad, tolerance_rad);
    }
  }
}

TEST(AlignPoses, IgnoresACommonErrorOfTheCameraMount) {
  const CaptureSet set = test_grid(9);
  const FramePoses nominal = nominal_poses(set);
  FramePoses truth = nominal;
  const Eigen::Matrix3d askew = world_from_camera({0.1, -0.05, 0.03});
  for (auto& pose : truth) pose->world_from_camera = askew;
  const FramePoses solved = moved_away(truth, 0.5, 6);
  const FramePoses back = aligned(solved, align_poses(set, solved, nominal));
  EXPECT_LT(largest_difference(back, truth).rotation_rad, 1e-4);
  EXPECT_LT(largest_difference(back, truth).position_m, 1e-4);
}

TEST(AlignPoses, TakesTheScaleFromTheSliderNotFromThePlan) {
  const CaptureSet set = test_grid(30);
  // Rails planned 1 m apart that are 1.2 m apart.
  FramePoses truth = nominal_poses(set);
  for (const int line : {1, 3}) {
    for (const int frame : set.lines[line].frames) {
      Eigen::Vector3d& at = truth[frame]->position_m;
      (line == 1 ? at.z() : at.x()) += 0.2;
    }
  }
  const PoseAlignment alignment = align_poses(set, moved_away(truth, 3.0, 1), nominal_poses(set));
  EXPECT_NEAR(alignment.scale, 1.0 / 3.0, 1e-9);
  EXPECT_GT(alignment.scale_pairs, 50);
}

TEST(AlignPoses, ReportsARankOfZeroForOnePoint) {
  CaptureSet set = test_line(2);
  set.frames[1].nominal_m = set.frames[0].nominal_m;
  const PoseAlignment alignment = align_poses(set, nominal_poses(set), nominal_poses(set));
  EXPECT_EQ(alignment.rank, 0);
  EXPECT_EQ(alignment.scale_pairs, 0);
  EXPECT_EQ(alignment.scale, 1.0);
  EXPECT_LT((alignment.rotation - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(AlignPoses, CountsOnlyFramesWithBothPoses) {
  const CaptureSet set = test_line(5);
  FramePoses solved = nominal_poses(set);
  solved[1].reset();
  EXPECT_EQ(align_poses(set, solved, nominal_poses(set)).frames, 4);
  EXPECT_THROW(align_poses(set, FramePoses(5), nominal_poses(set)), Error);
}

TEST(AlignPoses, ScalesSigmasOfPositions) {
  const CaptureSet set = test_line(3);
  FramePoses poses = nominal_poses(set);
  poses[0]->position_sigma_mm = 0.2;
  poses[0]->rotation_sigma_deg = 0.3;
  PoseAlignment alignment;
  alignment.scale = 5.0;
  const FramePoses moved = aligned(poses, alignment);
  EXPECT_DOUBLE_EQ(moved[0]->position_sigma_mm, 1.0);
  EXPECT_DOUBLE_EQ(moved[0]->rotation_sigma_deg, 0.3);
}

}  // namespace
}  // namespace raywalk::calibrate
