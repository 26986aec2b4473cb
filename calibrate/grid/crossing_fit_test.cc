#include "calibrate/grid/crossing_fit.h"

#include <gtest/gtest.h>

#include "calibrate/grid/rail_model.h"
#include "calibrate/grid/test_grid.h"

namespace raywalk::calibrate {
namespace {

// The true poses, with the line along x displaced by a rotation about its mean and a translation.
FramePoses displaced(const TestGrid& grid, const Eigen::Vector3d& turn_rad,
                     const Eigen::Vector3d& motion_m) {
  FramePoses poses = grid.truth;
  const Eigen::Matrix3d turn = matrix_of(turn_rad);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  const std::vector<int>& frames = grid.crossings[0].frames_x;
  for (const int frame : frames) middle += poses[static_cast<size_t>(frame)]->position_m;
  middle /= static_cast<double>(frames.size());
  for (const int frame : frames) {
    FramePose& pose = *poses[static_cast<size_t>(frame)];
    pose.position_m = middle + turn * (pose.position_m - middle) + motion_m;
    pose.world_from_camera = turn * pose.world_from_camera;
  }
  return poses;
}

TestGrid one_crossing(TestGridSettings settings, unsigned seed) {
  settings.lines_x = settings.lines_z = 1;
  settings.stations = 41;
  return TestGridMaker(settings, seed).make();
}

CrossingFitScale scale_of(const TestGrid& grid) { return fit_scale(grid_scale(grid.set)); }

TEST(CrossingFitTest, RecoversALargeMotion) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const TestGrid grid = one_crossing({.matches = 150, .wrong_share = 0.3}, seed);
    const Eigen::Vector3d turn(0.12, -0.1, 0.08);  // 10 degrees
    const Eigen::Vector3d motion(0.05, -0.04, 0.045);
    const CrossingFit fit =
        fit_crossing(grid.crossings[0].matches, displaced(grid, turn, motion), scale_of(grid));
    const Eigen::Vector3d left = vector_of(matrix_of(fit.rotation_rad) * matrix_of(turn));
    EXPECT_LT(degrees_from_radians(left.norm()), 0.06);
    EXPECT_LT((fit.motion_m + motion).norm(), 4e-3);
    EXPECT_NEAR(degrees_from_radians(fit.noise_rad), 0.05, 0.02);
    EXPECT_NEAR(static_cast<double>(fit.inliers) / (150 * 9), 0.7, 0.05);
  }
}

// The squared Mahalanobis distance of the errors has the mean 6.
TEST(CrossingFitTest, CovarianceIsHonest) {
  double square = 0.0;
  constexpr int kDraws = 25;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    const TestGrid grid = one_crossing({.matches = 40, .wrong_share = 0.0}, 50 + seed);
    const CrossingFit fit = fit_crossing(grid.crossings[0].matches, grid.truth, scale_of(grid));
    Eigen::Matrix<double, 6, 1> error;
    error << fit.motion_m, fit.rotation_rad;
    square += error.dot(fit.covariance.ldlt().solve(error)) / kDraws;
  }
  // Here the noise of each ray is independent for each match, so the factor 3 for shared features
  // makes the covariance too large.
  EXPECT_GT(3.0 * square, 3.5);
  EXPECT_LT(3.0 * square, 9.0);
}

// Cameras at one position have no parallax: the rotation is determined, the position is not, and
// there is no division by zero.
TEST(CrossingFitTest, CoincidentStationsDetermineRotationOnly) {
  TestGrid grid = one_crossing({.matches = 0}, 4);
  TestGridMaker random({}, 5);
  const auto x = static_cast<size_t>(grid.crossings[0].frames_x.front());
  const auto z = static_cast<size_t>(grid.crossings[0].frames_z.front());
  grid.truth[x]->position_m = grid.truth[z]->position_m;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d seen = random.normal3(1.0).normalized();
    grid.crossings[0].matches.push_back(
        {.frame_x = static_cast<int>(x),
         .frame_z = static_cast<int>(z),
         .ray_x = {.bearing = grid.truth[x]->world_from_camera.transpose() * seen},
         .ray_z = {.bearing =
                       (grid.truth[z]->world_from_camera.transpose() * seen + random.normal3(1e-3))
                           .normalized()}});
  }
  const CrossingFit fit = fit_crossing(
      grid.crossings[0].matches, displaced(grid, {0.05, 0.0, -0.05}, {0, 0, 0}), scale_of(grid));
  const Eigen::Vector3d left = vector_of(matrix_of(fit.rotation_rad) * matrix_of({0.05, 0, -0.05}));
  EXPECT_LT(left.norm(), 6e-4);
  EXPECT_TRUE(fit.covariance.allFinite());
}

TEST(CrossingFitTest, TooFewMatchesGiveNoInliers) {
  TestGrid grid = one_crossing({.matches = 1}, 6);
  grid.crossings[0].matches.resize(7);
  const CrossingFit fit = fit_crossing(grid.crossings[0].matches, grid.truth, scale_of(grid));
  EXPECT_EQ(fit.inliers, 0);
  EXPECT_EQ(fit.inlier.size(), 7U);
}

TEST(MatchResidualTest, WhiteningIsTheInverseRootOfTheCovariance) {
  const WorldRay a{{0.02, -0.01, 0.03}, Eigen::Vector3d(0.1, 0.2, 1.0).normalized()};
  const WorldRay b{{0.0, 0.0, 0.0}, Eigen::Vector3d(0.12, 0.2, 1.0).normalized()};
  const InverseDepths depth{0.7, 0.4};
  const double noise = 1e-3;
  const Whitening whitening = whitening_of(a, b, depth, noise);
  const Eigen::Vector3d baseline = a.origin_m - b.origin_m;
  const Eigen::Vector3d g = baseline - b.direction * b.direction.dot(baseline);
  const Eigen::Matrix3d covariance = 2.0 * noise * noise * Eigen::Matrix3d::Identity() +
                                     depth.sigma * depth.sigma * g * g.transpose();
  EXPECT_LT((whitening * covariance * whitening.transpose() - Eigen::Matrix2d::Identity()).norm(),
            1e-9);
  EXPECT_LT((whitening * b.direction).norm(), 1e-9 * whitening.norm());
}

TEST(MatchResidualTest, APointAtTheMeanDistanceHasNoResidual) {
  const Eigen::Vector3d point(1.0, -0.5, 2.0), a(0.1, 0.0, 0.2), b(-0.05, 0.03, 0.1);
  const Eigen::Vector3d from_a = point - a;
  const Eigen::Vector3d difference = direction_difference<double>(
      a, from_a.normalized(), b, (point - b).normalized(), 1.0 / from_a.norm());
  EXPECT_LT(difference.norm(), 1e-12);
}

}  // namespace
}  // namespace raywalk::calibrate
