#include "calibrate/lens/lens_bundle.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <random>

#include "calibrate/base/test_lines.h"
#include "calibrate/lens/camera_model.h"
#include "calibrate/lens/lens_test_camera.h"
#include "core/base/error.h"

namespace raywalk::calibrate {
namespace {

using Eigen::Vector3d;

constexpr PanoramaSize kBundlePicture{1120, 560};

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  double normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(engine_); }
  Vector3d normal_vector(double sigma) { return {normal(sigma), normal(sigma), normal(sigma)}; }
  Eigen::Matrix3d turn(double sigma_deg) {
    const double sigma_rad = radians_from_degrees(sigma_deg);
    return world_from_camera({normal(sigma_rad), normal(sigma_rad), normal(sigma_rad)});
  }

 private:
  std::mt19937_64 engine_;
};

struct World {
  double noise_px = 0.2;
  double outliers = 0.0;  // share of observations that are somewhere else
  double turn_deg = 1.0;  // by which every line and its camera is turned off the plan
  double shift_m = 0.02;
  int points = 300;
};

// Four lines of six stations in a box of points, seen through the true lenses.
BundleInput observed(const World& world, const DualFisheyeLayout& truth, Random* random) {
  BundleInput input;
  input.start = plain_camera(kBundlePicture).layout;
  input.start.front.largest_angle_rad = input.start.back.largest_angle_rad =
      radians_from_degrees(99.0);
  const CaptureSet grid = test_grid(6);
  input.lines = grid.lines.size();
  std::vector<BundlePose> poses;
  for (std::size_t line = 0; line < input.lines; ++line) {
    const Eigen::Matrix3d line_turn = random->turn(world.turn_deg);
    const Eigen::Matrix3d camera_turn = random->turn(world.turn_deg);
    const Vector3d shift_m = random->normal_vector(world.shift_m);
    for (const int frame : grid.lines[line].frames) {
      const Vector3d nominal_m = grid.frames[static_cast<std::size_t>(frame)].nominal_m;
      const Eigen::Matrix3d jitter = random->turn(0.1);
      input.stations.push_back({line, nominal_m, Eigen::Matrix3d::Identity()});
      poses.push_back(
          {line_turn * nominal_m + shift_m + random->normal_vector(0.001), camera_turn * jitter});
    }
  }
  const Eigen::Matrix3d back_from_camera = world_from_camera(truth.back_attitude).transpose();
  for (int p = 0; p < world.points; ++p) {
    Vector3d point(random->uniform(-2.2, 2.2), random->uniform(-1.3, 1.3),
                   random->uniform(-2.6, 2.6));
    const int wall = p % 3;
    const double half_m = wall == 0 ? 2.2 : wall == 1 ? 1.3 : 2.6;
    point[wall] = random->uniform(0, 1) < 0.5 ? -half_m : half_m;
    BundleTrack track;
    const auto first_line = static_cast<std::size_t>(random->uniform(0, 4));
    for (std::size_t s = 0; s < poses.size(); ++s) {
      if (input.stations[s].line != first_line && random->uniform(0, 1) < 0.8) continue;
      const Vector3d in_camera =
          poses[s].world_from_camera.transpose() * (point - poses[s].position_m);
      for (const bool back : {false, true}) {
        const auto pixel =
            back ? project(truth.back, back_from_camera * (in_camera - truth.back_position_m))
                 : project(truth.front, Vector3d(in_camera - truth.front_position_m));
        if (!pixel) continue;
        PixelPosition seen{pixel->u + random->normal(world.noise_px),
                           pixel->v + random->normal(world.noise_px)};
        if (random->uniform(0, 1) < world.outliers) {
          seen.u += random->normal(100.0);
          seen.v += random->normal(100.0);
        }
        track.push_back({s, back, seen});
      }
    }
    if (track.size() >= 3) input.tracks.push_back(track);
  }
  return input;
}

TEST(LensBundleTest, RecoversLensesWithinTheirSigmas) {
  const DualFisheyeLayout truth = true_camera(kBundlePicture).layout;
  ASSERT_GT(imaging_difference_px(plain_camera(kBundlePicture).layout, truth), 3.0);
  constexpr int kRuns = 3;
  double squares = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Random random(static_cast<std::uint64_t>(run + 1));
    const BundleInput input = observed({}, truth, &random);
    const BundleResult result = adjust_bundle(input, start_of(input), {4.0, 50, true});
    const DualFisheyeLayout fitted = layout_of(result.state.camera, input.start);
    EXPECT_LT(imaging_difference_px(fitted, truth), 0.3) << "run " << run;
    EXPECT_LT((fitted.front_position_m - truth.front_position_m).norm(), 0.002) << "run " << run;
    EXPECT_NEAR(result.sigma_px, 0.2, 0.03);
    ASSERT_TRUE(result.covariance);
    const CameraUncertainty sigma = uncertainty_of(result.state.camera, *result.covariance, fitted);
    EXPECT_LT(sigma.worst_px(), 0.3);
    // Squared errors over their variances, by parameter: their mean is 1 if the covariance is
    // right.
    const CameraParameters wanted = parameters_of(truth);
    for (int i = 0; i < kLensParameters; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double front = result.state.camera.front[at] - wanted.front[at];
      const double back = result.state.camera.back[at] - wanted.back[at];
      const int b = kLensParameters + i;
      squares += front * front / (*result.covariance)(i, i) / (2 * kLensParameters * kRuns);
      squares += back * back / (*result.covariance)(b, b) / (2 * kLensParameters * kRuns);
    }
  }
  EXPECT_GT(squares, 0.2);
  EXPECT_LT(squares, 3.0);
}

TEST(LensBundleTest, WrongMatchesAndARailFarOffThePlanDoNotMatter) {
  const DualFisheyeLayout truth = true_camera(kBundlePicture).layout;
  for (const World& world : {World{.outliers = 0.15}, World{.turn_deg = 5.0, .shift_m = 0.05}}) {
    Random random(9);
    const BundleInput input = observed(world, truth, &random);
    const double tolerance_px = world.turn_deg > 1.0 ? 15.0 : 4.0;
    const BundleResult result = adjust_bundle(input, start_of(input), {tolerance_px, 50, false});
    const DualFisheyeLayout fitted = layout_of(result.state.camera, input.start);
    EXPECT_LT(imaging_difference_px(fitted, truth), 0.3) << world.turn_deg;
    if (world.outliers > 0.0) {
      EXPECT_GT(result.observations_dropped, static_cast<int>(input.tracks.size()) / 4);
    }
  }
}

TEST(LensBundleTest, InconsistentFeaturesAreRefused) {
  Random random(5);
  const BundleInput input =
      observed({.outliers = 1.0}, true_camera(kBundlePicture).layout, &random);
  EXPECT_THROW(adjust_bundle(input, start_of(input), {4.0, 50, false}), Error);
}

TEST(CameraModelTest, BackLensIsTurnedAboutItsOwnAxesAndTheMiddleStays) {
  const DualFisheyeLayout start = plain_camera(kBundlePicture).layout;
  // Turned from the start: 2 degrees about the back lens's own x axis, which is a pitch downwards.
  CameraParameters parameters = parameters_of(start);
  parameters.back_pose = {radians_from_degrees(2.0), 0, 0, 0.001, 0.002, -0.01};
  const DualFisheyeLayout layout = layout_of(parameters, start);
  EXPECT_NEAR(std::fabs(layout.back_attitude.pitch_rad), radians_from_degrees(2.0), 1e-12);
  EXPECT_NEAR((layout.back_position_m - Vector3d(0.0005, 0.001, -0.005)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((layout.front_position_m + layout.back_position_m).norm(), 0.0, 1e-15);
}

// On the axis the derivatives are those of the pinhole camera with the same focal length.
TEST(CameraModelTest, DerivativesExistOnTheAxis) {
  using Jet = ceres::Jet<double, 2>;
  const double lens[7] = {100, 50, 80, 0.1, 0, 0, 0};
  Jet parameters[7];
  for (int i = 0; i < 7; ++i) parameters[i] = Jet(lens[i]);
  const Jet direction[3] = {Jet(0.0, 0), Jet(0.0, 1), Jet(2.0)};
  Jet pixel[2];
  image_direction(parameters, direction, pixel);
  EXPECT_EQ(pixel[0].a, 100.0);
  EXPECT_NEAR(pixel[0].v[0], 40.0, 1e-12);
  EXPECT_NEAR(pixel[1].v[1], -40.0, 1e-12);
}

}  // namespace
}  // namespace raywalk::calibrate
