#include "calibrate/poses/refine_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>

#include "calibrate/base/rotation.h"
#include "calibrate/base/stop_on_interrupt.h"
#include "calibrate/poses/align_poses.h"
#include "calibrate/poses/pose_accuracy.h"
#include "calibrate/poses/test_rail_scene.h"
#include "core/base/error.h"

namespace raywalk::calibrate {
namespace {

// The poses in another frame and scale.
FramePoses moved_away(const FramePoses& poses, double scale, unsigned seed) {
  std::mt19937 random(seed);
  return aligned(poses, {.scale = scale,
                         .rotation = random_turn(&random, 170.0),
                         .translation_m = random_vector(&random, 5.0 * scale)});
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
  for (auto& pose : truth) pose->world_from_camera = world_from_camera({0.1, -0.05, 0.03});
  const FramePoses solved = moved_away(truth, 0.5, 6);
  const FramePoses back = aligned(solved, align_poses(set, solved, nominal));
  EXPECT_LT(largest_difference(back, truth).rotation_rad, 1e-4);
  EXPECT_LT(largest_difference(back, truth).position_m, 1e-4);
}

TEST(AlignPoses, TakesTheScaleFromTheSliderNotFromThePlan) {
  const CaptureSet set = test_grid(30);
  // Rails planned 1 m apart that are 1.2 m apart.
  FramePoses truth = nominal_poses(set);
  for (const int frame : set.lines[1].frames) truth[frame]->position_m.z() += 0.2;
  for (const int frame : set.lines[3].frames) truth[frame]->position_m.x() += 0.2;
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
  const FramePoses moved = aligned(poses, {.scale = 5.0});
  EXPECT_DOUBLE_EQ(moved[0]->position_sigma_mm, 1.0);
  EXPECT_DOUBLE_EQ(moved[0]->rotation_sigma_deg, 0.3);
}

constexpr PoseAnchor kAnchor{0.1, 0.1};

// Points with initial errors of a few centimetres, as by triangulation from the start.
SeenPoints blurred(SeenPoints points, double size_m, unsigned seed) {
  std::mt19937 random(seed);
  for (Eigen::Vector3d& point : points.points_m) point += random_vector(&random, size_m);
  return points;
}

// Aligned to the truth by a similarity, which is unobservable: the least-squares one for rotations
// (radians) and positions (in units of their spread) together.
FramePoses onto_truth(const FramePoses& poses, const FramePoses& truth) {
  const double count = static_cast<double>(poses.size());
  Eigen::Vector3d mean_m{0, 0, 0}, true_mean_m{0, 0, 0};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    mean_m += poses[i]->position_m / count;
    true_mean_m += truth[i]->position_m / count;
  }
  double square_m2 = 0.0, true_square_m2 = 0.0;
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero(), spread_m2 = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d at_m = poses[i]->position_m - mean_m;
    const Eigen::Vector3d true_m = truth[i]->position_m - true_mean_m;
    square_m2 += at_m.squaredNorm();
    true_square_m2 += true_m.squaredNorm();
    spread_m2 += true_m * at_m.transpose();
    turns += truth[i]->world_from_camera * poses[i]->world_from_camera.transpose();
  }
  PoseAlignment alignment;
  alignment.scale = std::sqrt(true_square_m2 / square_m2);
  alignment.rotation =
      nearest_rotation(turns + count * alignment.scale / true_square_m2 * spread_m2);
  alignment.translation_m = true_mean_m - alignment.scale * alignment.rotation * mean_m;
  return aligned(poses, alignment);
}

PoseDifference shape_difference(const FramePoses& poses, const FramePoses& truth) {
  return largest_difference(onto_truth(poses, truth), truth);
}

// From the nominal poses.
RefinedPoses refined_from_plan(const CaptureSet& set, const SeenPoints& points,
                               const PoseAnchor& anchor = kAnchor) {
  return refine_poses(set, nominal_poses(set), points, anchor, 1);
}

TEST(RefinePoses, HasTheAccuracyOfItsNoiseAndEstimatesIt) {
  const CaptureSet set = test_grid(6);
  const FramePoses truth = test_truth(set, {}, 5);
  const SeenPoints points = blurred(test_points(set, truth, 1500, 1.0, 0.5, 6), 0.05, 7);
  const RefinedPoses refined = refined_from_plan(set, points);
  // The unknowns absorb part of the noise: 24 * 6 + 1500 * 3 unknowns in 24000 equations.
  EXPECT_NEAR(refined.noise_px, 0.5 * std::sqrt(1.0 - 4644.0 / 24000.0), 0.04);
  EXPECT_LT(shape_difference(refined.poses, truth).position_m, 1e-3);
}

// The carriage rocks by a millimetre, which the feedback does not contain, and the start has every
// station exactly at its feedback's position. The pictures have to outweigh it.
TEST(RefinePoses, FollowsThePicturesWhereTheSliderIsWrong) {
  const CaptureSet set = test_line(31);
  const FramePoses truth = test_truth(set, {0.0, 0.0, 1e-3, 0.1}, 40);
  const SeenPoints points = blurred(test_points(set, truth, 1500, 1.0, 0.4, 41), 0.05, 42);
  const RefinedPoses refined = refined_from_plan(set, points);
  const double unsolved_m = shape_difference(nominal_poses(set), truth).position_m;
  EXPECT_GT(unsolved_m, 1e-3);
  EXPECT_LT(shape_difference(refined.poses, truth).position_m, 0.35 * unsolved_m);
}

TEST(RefinePoses, IsRobustToAFifthOfWrongMatches) {
  const CaptureSet set = test_grid(6);
  const FramePoses truth = test_truth(set, {}, 8);
  SeenPoints points = blurred(test_points(set, truth, 1000, 1.0, 0.3, 9), 0.05, 10);
  std::mt19937 random(11);
  for (std::size_t i = 0; i < points.observations.size(); i += 5) {
    Eigen::Vector3d& bearing = points.observations[i].bearing;
    bearing = (bearing + random_vector(&random, 0.05)).normalized();
  }
  const RefinedPoses refined = refined_from_plan(set, points);
  EXPECT_LT(shape_difference(refined.poses, truth).position_m, 2e-3);
  const auto inliers = std::count_if(refined.errors_px.begin(), refined.errors_px.end(),
                                     [&](double error) { return error < refined.inlier_px; });
  EXPECT_NEAR(static_cast<double>(inliers), 0.8 * 8000, 0.02 * 8000);
}

// The centres of the two lenses are in front of and behind the camera's middle. Points seen by one
// lens alone do not constrain its offset; those seen by both do.
TEST(RefinePoses, FindsExactPosesFromExactBearingsOfEachLens) {
  const CaptureSet set = test_grid(6);
  const FramePoses truth = test_truth(set, {0.02, 1.5, 0.0, 0.1}, 1);
  SeenPoints points = test_points(set, truth, 400, 1.0, 0.0, 2);
  for (PointObservation& observation : points.observations) {
    const FramePose& pose = *truth[observation.frame];
    observation.centre_m = {0, 0, observation.bearing.z() > 0 ? 0.005 : -0.005};
    const Eigen::Vector3d in_camera =
        pose.world_from_camera.transpose() * (points.points_m[observation.point] - pose.position_m);
    observation.bearing = (in_camera - observation.centre_m).normalized();
  }
  points = blurred(points, 0.05, 3);
  const RefinedPoses refined = refined_from_plan(set, points);
  const PoseDifference left = shape_difference(refined.poses, truth);
  EXPECT_LT(left.position_m, 2e-5);
  EXPECT_LT(left.rotation_rad, 2e-5);
  EXPECT_LT(refined.noise_px, 0.02);
  for (PointObservation& observation : points.observations) observation.centre_m.setZero();
  const RefinedPoses without = refined_from_plan(set, points);
  EXPECT_GT(without.noise_px, 3 * refined.noise_px);
}

// The result scales with the capture: no threshold is in metres.
TEST(RefinePoses, IsIndependentOfScale) {
  for (const double size : {1e-3, 1e3}) {
    const CaptureSet set = test_grid(5, size);
    const FramePoses truth = test_truth(set, {0.02 * size, 1.5, 0.0, 0.1}, 14);
    const SeenPoints points = blurred(test_points(set, truth, 300, size, 0.2, 15), 0.05 * size, 16);
    const PoseAnchor anchor{0.1 * size, 0.1};
    RefinedPoses refined = refined_from_plan(set, points, anchor);
    EXPECT_LT(shape_difference(refined.poses, truth).position_m, 1e-3 * size);
    set_sigmas(&refined, anchor);
    EXPECT_GT(refined.poses[3]->position_sigma_mm, 1e-3 * size);
    EXPECT_LT(refined.poses[3]->position_sigma_mm, 1.0 * size);
  }
}

TEST(RefinePoses, ThrowsWithoutObservations) {
  const CaptureSet set = test_grid(4);
  EXPECT_THROW(refined_from_plan(set, {}), Error);
}

// Mean squares of errors over sigmas in several draws: 1 if the sigmas are right.
struct SigmaRatio {
  double position = 0.0;
  double rotation = 0.0;
};

// With every observation that many times.
SigmaRatio sigma_ratio(int copies) {
  const CaptureSet set = test_grid(4);
  const FramePoses truth = test_truth(set, {}, 20);
  SigmaRatio ratio;
  int count = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    SeenPoints points = test_points(set, truth, 300, 1.0, 0.4, 100 + seed);
    const std::vector<PointObservation> once = points.observations;
    for (int copy = 1; copy < copies; ++copy) {
      points.observations.insert(points.observations.end(), once.begin(), once.end());
    }
    RefinedPoses refined = refine_poses(set, truth, points, kAnchor, 1);
    set_sigmas(&refined, kAnchor);
    const FramePoses back = onto_truth(refined.poses, truth);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double moved_mm = 1e3 * (back[i]->position_m - truth[i]->position_m).norm();
      const double turned_deg = degrees_from_radians(
          angle_between(back[i]->world_from_camera, truth[i]->world_from_camera));
      ratio.position += std::pow(moved_mm / back[i]->position_sigma_mm, 2) / 3.0;
      ratio.rotation += std::pow(turned_deg / back[i]->rotation_sigma_deg, 2) / 3.0;
      ++count;
    }
  }
  return {ratio.position / count, ratio.rotation / count};
}

TEST(Settle, KeepsConnectedPosesAndInliers) {
  const CaptureSet set = test_grid(6);
  const FramePoses truth = test_truth(set, {}, 25);
  SeenPoints points = test_points(set, truth, 800, 1.0, 0.3, 26);
  // Frame 5 sees next to nothing, and one observation in ten is wrong.
  std::erase_if(points.observations, [count = 0](const PointObservation& one) mutable {
    return one.frame == 5 && ++count > 10;
  });
  for (std::size_t i = 0; i < points.observations.size(); i += 10) {
    Eigen::Vector3d& bearing = points.observations[i].bearing;
    bearing = (bearing + Eigen::Vector3d(0.02, 0.03, -0.01)).normalized();
  }
  RefinedPoses refined = refine_poses(set, truth, points, kAnchor, 1);
  ASSERT_TRUE(refined.poses[5]);
  settle(&refined, kAnchor);
  EXPECT_FALSE(refined.poses[5]);
  EXPECT_EQ(std::count(refined.poses.begin(), refined.poses.end(), std::nullopt), 1);
  ASSERT_TRUE(refined.poses[4]);
  EXPECT_EQ(refined.poses[4]->origin, PoseOrigin::kSolved);
  EXPECT_GT(refined.poses[4]->observations, 30);
  EXPECT_GT(refined.poses[4]->residual_px, 0.1);
  EXPECT_GT(refined.poses[4]->position_sigma_mm, 0.0);
  EXPECT_LE(*std::max_element(refined.errors_px.begin(), refined.errors_px.end()),
            refined.inlier_px);
  ASSERT_EQ(refined.errors_px.size(), refined.points.observations.size());
  EXPECT_GT(refined.points.observations.size(), points.observations.size() * 8 / 10);
  for (const PointObservation& one : refined.points.observations) EXPECT_NE(one.frame, 5U);
}

TEST(Settle, LeavesNothingWhereNothingIsConnected) {
  const CaptureSet set = test_grid(6);
  const FramePoses truth = test_truth(set, {}, 27);
  RefinedPoses refined =
      refine_poses(set, truth, test_points(set, truth, 20, 1.0, 0.3, 28), kAnchor, 1);
  settle(&refined, kAnchor);
  EXPECT_TRUE(refined.points.observations.empty());
}

// Repeating every observation with the same error adds no information, so sigmas must not shrink.
TEST(PoseCovariance, MatchesTheSpreadOfRepeatedDraws) {
  for (const int copies : {1, 4}) {
    const SigmaRatio ratio = sigma_ratio(copies);
    EXPECT_NEAR(ratio.position, 1.0, 0.35) << copies;
    EXPECT_NEAR(ratio.rotation, 1.0, 0.35) << copies;
  }
}

// The flag never goes back, so the signal is raised in a process of its own.
TEST(StopOnInterruptDeathTest, AbortsTheSolverAfterAnInterrupt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        std::raise(SIGINT);
        StopOnInterrupt stop;
        std::exit(stop(ceres::IterationSummary()) == ceres::SOLVER_ABORT ? 42 : 1);
      },
      testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace raywalk::calibrate
