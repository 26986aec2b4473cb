#include "calibrate/lens/lens_bundle.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "calibrate/base/test_lines.h"
#include "calibrate/lens/camera_model.h"
#include "calibrate/lens/image_circle.h"
#include "calibrate/lens/lens_features.h"
#include "calibrate/lens/lens_test_camera.h"
#include "calibrate/lens/lens_tracks.h"
#include "core/base/error.h"
#include "core/geometry/test_pixels.h"

namespace raywalk::calibrate {
namespace {

using Eigen::Vector3d;

// --- What is found in the pictures: features, their tracks, the rim of the image circle ---------

constexpr PanoramaSize kFeaturePicture{640, 320};

// Blurred bright dots on grey, at subpixel positions.
cv::Mat dots_at(const std::vector<PixelPosition>& places) {
  constexpr double kSigma_px = 2.5;
  cv::Mat picture(kFeaturePicture.height, kFeaturePicture.width, CV_8UC3);
  for (const auto [u, v] : pixels_of({picture.cols, picture.rows})) {
    double level = 70.0;
    for (const PixelPosition& place : places) {
      const double square = (u - place.u) * (u - place.u) + (v - place.v) * (v - place.v);
      level += 150.0 * std::exp(-0.5 * square / (kSigma_px * kSigma_px));
    }
    picture.at<cv::Vec3b>(v, u) = cv::Vec3b::all(cv::saturate_cast<uchar>(level));
  }
  return picture;
}

double nearest_px(const LensFeatures& found, PixelPosition place, bool back) {
  double nearest = 1e9;
  for (const LensFeature& feature : found.features) {
    if (feature.back != back) continue;
    nearest = std::min(nearest, std::hypot(feature.seen.u - place.u, feature.seen.v - place.v));
  }
  return nearest;
}

TEST(LensFeaturesTest, FeaturesHaveTheRightPositionAndLensUnlessMasked) {
  const DualFisheyeCamera camera = plain_camera(kFeaturePicture);
  const std::vector<PixelPosition> places{{100.3, 120.6}, {170.8, 200.1}, {450.4, 90.5}};
  const cv::Mat picture = dots_at(places);
  const LensFeatures found = find_lens_features({picture, picture}, camera, {});
  EXPECT_LT(nearest_px(found, places[0], false), 0.05);
  EXPECT_LT(nearest_px(found, places[1], false), 0.05);
  EXPECT_LT(nearest_px(found, places[2], true), 0.05);
  EXPECT_EQ(found.descriptors.rows, static_cast<int>(found.features.size()));
  cv::Mat mask(picture.size(), CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 99, 320)).setTo(0);  // beside the first
  mask(cv::Rect(449, 89, 3, 3)).setTo(0);  // within the third
  const LensFeatures unmasked = find_lens_features({picture, picture, mask}, camera, {});
  EXPECT_GT(nearest_px(unmasked, places[0], false), 5.0);
  EXPECT_LT(nearest_px(unmasked, places[1], false), 0.05);
  EXPECT_GT(nearest_px(unmasked, places[2], true), 5.0);
}

TEST(LensFeaturesTest, TheNadirAndTheRimAreExcluded) {
  const DualFisheyeCamera camera = plain_camera(kFeaturePicture);
  const PixelPosition middle = camera.layout.front.centre;
  const double rim_px = 0.5 * kFeaturePicture.height * 0.99;
  const PixelPosition below{middle.u + 3.0, middle.v + 0.8 * rim_px};  // 76 degrees below the axis
  const PixelPosition at_rim{middle.u - rim_px + 2.0, middle.v};
  const cv::Mat picture = dots_at({below, at_rim});
  const LensFeatures all = find_lens_features({picture, picture}, camera, {});
  EXPECT_LT(nearest_px(all, below, false), 0.1);
  EXPECT_GT(nearest_px(all, at_rim, false), 5.0);
  const LensFeatures above = find_lens_features({picture, picture}, camera,
                                                {.ignore_below_rad = radians_from_degrees(20.0)});
  EXPECT_GT(nearest_px(above, below, false), 5.0);
}

// Three stations with four features each: 0 and 1 of the front lens, 2 and 3 of the back lens.
std::vector<LensFeatures> three_stations() {
  std::vector<LensFeatures> stations(3);
  for (LensFeatures& station : stations) {
    for (int i = 0; i < 4; ++i) station.features.push_back({{10.0 * i, 5.0}, i >= 2});
  }
  return stations;
}

TEST(LensTracksTest, MatchesJoinAcrossStationsAndLenses) {
  const std::vector<LensFeatures> stations = three_stations();
  const std::vector<ViewMatches> matches{
      {0, 1, {{0, 1}}}, {1, 2, {{1, 0}, {2, 2}}}, {2, 2, {{0, 3}}}};
  const std::vector<BundleTrack> tracks = join_tracks(stations, matches);
  // The other one, feature 2 at stations 1 and 2, has two observations only.
  ASSERT_EQ(tracks.size(), 1U);
  EXPECT_EQ(tracks[0].size(), 4U);
}

TEST(LensTracksTest, InconsistentTracksAreDropped) {
  const std::vector<ViewMatches> matches{{0, 1, {{0, 0}}}, {1, 2, {{0, 0}}}, {0, 2, {{1, 0}}}};
  EXPECT_TRUE(join_tracks(three_stations(), matches).empty());
}

// A track of the front lens seen in a direction, moving that far between two stations and a third.
BundleTrack seen_at(const FisheyeLens& lens, const Vector3d& direction, double moves_px) {
  const PixelPosition at = *project(lens, direction);
  return {{0, false, at},
          {1, false, {at.u + 0.5 * moves_px, at.v}},
          {2, false, {at.u + moves_px, at.v}}};
}

TEST(LensTracksTest, OnlyStillTracksBelowTheCameraAreRemoved) {
  const DualFisheyeLayout layout = plain_camera({1120, 560}).layout;
  const std::vector<BundleStation> stations{{0, {0, 0, 0}}, {0, {0.1, 0, 0}}, {0, {0.2, 0, 0}}};
  const Vector3d down(0, -1, 0);
  const double cone_rad = radians_from_degrees(40.0);
  const auto removed = [&](const Vector3d& direction, double moves_px,
                           const std::vector<BundleStation>& seen_from) {
    std::vector<BundleTrack> tracks{seen_at(layout.front, direction, moves_px)};
    return remove_still_tracks(layout, seen_from, down, cone_rad, &tracks) == 1 && tracks.empty();
  };
  const Vector3d below = Vector3d(0.1, -1.0, 0.3).normalized();
  EXPECT_TRUE(removed(below, 0.3, stations));
  EXPECT_FALSE(removed(below, 5.0, stations));                             // the floor
  EXPECT_FALSE(removed(Vector3d(0, 0.2, 1).normalized(), 0.0, stations));  // the sky
  EXPECT_FALSE(removed(below, 0.3, std::vector<BundleStation>(3)));        // nothing moved
}

TEST(LensTracksTest, ThinningKeepsTracksOfBothLenses) {
  std::vector<BundleTrack> tracks;
  for (std::size_t i = 0; i < 1000; ++i) {
    tracks.push_back({{i, false, {}}, {i + 1, false, {}}, {i + 2, i % 10 == 0, {}}});
  }
  std::vector<BundleTrack> thinned = tracks;
  thin_tracks(300, &thinned);
  ASSERT_EQ(thinned.size(), 300U);
  const auto of_both = [](const BundleTrack& track) { return track.back().back; };
  const auto of_first_half = [](const BundleTrack& track) { return track.front().station < 500; };
  EXPECT_EQ(std::ranges::count_if(thinned, of_both), 100);
  EXPECT_NEAR(std::ranges::count_if(thinned, of_first_half), 150, 2);
  thin_tracks(5000, &tracks);
  EXPECT_EQ(tracks.size(), 1000U);
}

constexpr PanoramaSize kCirclePicture{1120, 560};

// Bright discs in the fields of view of the true lenses.
cv::Mat lit_circles(const DualFisheyeLayout& layout, double level) {
  cv::Mat picture(kCirclePicture.height, kCirclePicture.width, CV_8UC1, cv::Scalar(2));
  for (const auto [u, v] : pixels_of({picture.cols, picture.rows})) {
    const PixelPosition at{static_cast<double>(u), static_cast<double>(v)};
    const bool back = belongs_to_back(layout, at);
    if (unproject(back ? layout.back : layout.front, at)) {
      picture.at<uchar>(v, u) = cv::saturate_cast<uchar>(level);
    }
  }
  return picture;
}

TEST(ImageCircleTest, RimIsFoundDespiteDarkObjectsNearIt) {
  const DualFisheyeCamera truth = true_camera(kCirclePicture), start = plain_camera(kCirclePicture);
  cv::Mat picture = lit_circles(truth.layout, 180.0);
  cv::rectangle(picture, {240, 430, 90, 130}, cv::Scalar(3), cv::FILLED);  // a pole, to the rim
  for (const bool back : {false, true}) {
    const FisheyeLens& lens = back ? truth.layout.back : truth.layout.front;
    const auto circle = find_image_circle(picture, start, back);
    ASSERT_TRUE(circle);
    EXPECT_NEAR(circle->centre.u, lens.centre.u, 0.5);
    EXPECT_NEAR(circle->centre.v, lens.centre.v, 0.5);
    EXPECT_NEAR(circle->radius_px, rim_radius_px(lens), 0.7);
  }
}

TEST(ImageCircleTest, NoCircleIsFoundWithoutARim) {
  const DualFisheyeCamera start = plain_camera(kCirclePicture);
  const cv::Mat lit_all_over(kCirclePicture.height, kCirclePicture.width, CV_8UC1, cv::Scalar(180));
  EXPECT_FALSE(find_image_circle(lit_all_over, start, false));
  EXPECT_FALSE(find_image_circle(lit_circles(start.layout, 8.0), start, false));  // night
}

TEST(ImageCircleTest, FieldOfViewEndsAtTheRimOrWhereTheRadiusStopsGrowing) {
  const FisheyeLens truth = true_camera(kCirclePicture).layout.front;
  FisheyeLens lens = truth;
  lens.largest_angle_rad = 0.3;
  EXPECT_NEAR(with_rim_at(lens, rim_radius_px(truth)).largest_angle_rad, truth.largest_angle_rad,
              2e-4);
  lens.k = {-0.2, 0.0, 0.0, 0.0};  // grows up to t = sqrt(1 / 0.6)
  const FisheyeLens folded = with_rim_at(lens, 1e6);
  EXPECT_NEAR(folded.largest_angle_rad, std::sqrt(1.0 / 0.6), 2e-4);
  EXPECT_NO_THROW(require_monotonic_radius(folded));
}

// --- The adjustment -----------------------------------------------------------------------------

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
      const Vector3d nominal_m = grid.frames[frame].nominal_m;
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
        const bool is_outlier = random->uniform(0, 1) < world.outliers;
        const double noise_px = is_outlier ? 100.0 : world.noise_px;
        track.push_back(
            {s, back, {pixel->u + random->normal(noise_px), pixel->v + random->normal(noise_px)}});
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
      const double front = result.state.camera.front[i] - wanted.front[i];
      const double back = result.state.camera.back[i] - wanted.back[i];
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
