#include "calibrate/rails/fit_rails.h"

#include <gtest/gtest.h>

#include <random>

#include "calibrate/base/rotation.h"
#include "calibrate/base/test_lines.h"

namespace raywalk::calibrate {
namespace {

using P = RailParameter;

// A line of stations along an axis, 25 mm apart times `scale`, at the nominal height 0.
CaptureSet line_of(int stations, LineAxis axis, double scale = 1.0) {
  CaptureSet set;
  add_test_line(&set, "x0", axis, 0.3 * scale, 0.025 * scale * (stations - 1), stations);
  return set;
}

// A rail laid askew, bent and twisted.
Rail true_rail(const CaptureSet& set, double scale = 1.0) {
  Rail rail{.frame = rail_frame(set, 0)};
  rail.parameters[P::kOffset] = 0.02 * scale;
  rail.parameters[P::kOffset + 1] = -0.01 * scale;
  rail.parameters[P::kHeading] = 0.03;
  rail.parameters[P::kTilt] = -0.02;
  rail.parameters[P::kRotation + 1] = 0.05;
  rail.parameters[P::kBow] = 0.002 * scale;
  rail.parameters[P::kTwist + 2] = 0.01;
  return rail;
}

// Stations on the rail, with normal scatter.
FramePoses on_rail(const CaptureSet& set, const Rail& rail, const RailScatter& scatter,
                   unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const RailAxes<double> axes =
      rail_axes(rail.frame.axis, rail.parameters[P::kHeading], rail.parameters[P::kTilt]);
  FramePoses poses;
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    FramePose pose = pose_on_rail(set, rail, i);
    pose.origin = PoseOrigin::kSolved;
    pose.position_m += scatter.along_m * normal(random) * axes.direction +
                       scatter.across_m * normal(random) * axes.across +
                       scatter.across_m * normal(random) * axes.up;
    const Eigen::Vector3d turn(normal(random), normal(random), normal(random));
    pose.world_from_camera = matrix_of(scatter.rotation_rad * turn) * pose.world_from_camera;
    poses.emplace_back(pose);
  }
  return poses;
}

// The largest distance of the predicted from the true stations, metres.
double largest_error_m(const CaptureSet& set, const Rail& rail, const Rail& truth) {
  return largest_difference(on_rail(set, rail, {}, 1), on_rail(set, truth, {}, 1)).position_m;
}

TEST(FitRails, FindsARailLaidAskewAtAnyScale) {
  for (const double scale : {1e-3, 1.0, 1e3}) {
    for (const LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
      const CaptureSet set = line_of(41, axis, scale);
      const Rail truth = true_rail(set, scale);
      const Rail rail = fit_rails(set, on_rail(set, truth, {}, 1)).front();
      EXPECT_LT(largest_error_m(set, rail, truth), 1e-5 * scale);
      EXPECT_NEAR(rail.parameters[P::kHeading], 0.03, 1e-4);
      EXPECT_NEAR(rail.parameters[P::kTwist + 2], 0.01, 1e-4);
      EXPECT_EQ(rail.stations, 41);
    }
  }
}

TEST(FitRails, MeasuresTheScatterOfItsStations) {
  const CaptureSet set = line_of(201, LineAxis::kX);
  const RailScatter scatter{.along_m = 4e-4, .across_m = 2e-4, .rotation_rad = 1e-3};
  const Rail truth = true_rail(set);
  const Rail rail = fit_rails(set, on_rail(set, truth, scatter, 2)).front();
  EXPECT_NEAR(rail.scatter.along_m, scatter.along_m, 0.8e-4);
  EXPECT_NEAR(rail.scatter.across_m, scatter.across_m, 0.4e-4);
  EXPECT_NEAR(rail.scatter.rotation_rad, scatter.rotation_rad, 2e-4);
  EXPECT_LT(largest_error_m(set, rail, truth), 2e-4);
}

// A third of the stations lie elsewhere, all on one side.
TEST(FitRails, IsNotMovedByStationsThatContradict) {
  const CaptureSet set = line_of(40, LineAxis::kZ);
  const Rail truth = true_rail(set);
  FramePoses poses = on_rail(set, truth, {1e-4, 1e-4, 1e-4}, 3);
  for (std::size_t i = 0; i < poses.size(); i += 3) {
    poses[i]->position_m += Eigen::Vector3d(0.05, 0.03, 0.1);
    poses[i]->world_from_camera = matrix_of({0.2, 0, 0}) * poses[i]->world_from_camera;
  }
  const Rail rail = fit_rails(set, poses).front();
  EXPECT_LT(largest_error_m(set, rail, truth), 2e-4);
  EXPECT_NEAR(deviation_of(set, rail, 0, *poses[0]).off_m.norm(),
              Eigen::Vector3d(0.05, 0.03, 0.1).norm(), 1e-3);
}

TEST(FitRails, PredictsStationsWithoutAPose) {
  const CaptureSet set = line_of(41, LineAxis::kX);
  const Rail truth = true_rail(set);
  FramePoses poses = on_rail(set, truth, {2e-4, 2e-4, 1e-3}, 4);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i % 4 != 0) poses[i].reset();
  }
  const Rail rail = fit_rails(set, poses).front();
  EXPECT_EQ(rail.stations, 11);
  EXPECT_LT(largest_error_m(set, rail, truth), 1e-3);
  const FramePose predicted = pose_on_rail(set, rail, 1);
  EXPECT_EQ(predicted.origin, PoseOrigin::kRail);
  EXPECT_GT(predicted.position_sigma_mm, 0.05);
  EXPECT_LT(predicted.position_sigma_mm, 1.0);
}

// With few stations the rail is the planned line, moved and turned; their scatter is that of a
// typical rail.
TEST(FitRails, BendsOnlyAsItsStationsSupport) {
  for (const int stations : {1, 2, 3, 5}) {
    const CaptureSet set = line_of(stations, LineAxis::kX);
    const Rail truth = true_rail(set);
    const Rail rail = fit_rails(set, on_rail(set, truth, {}, 5)).front();
    EXPECT_EQ(rail.parameters[P::kBow], 0.0);
    EXPECT_GE(rail.scatter.along_m, 0.025 / 25.0 - 1e-12);
    EXPECT_LT(largest_error_m(set, rail, truth), 4e-3);
  }
}

TEST(FitRails, OfALineWithoutPosesIsThePlan) {
  const CaptureSet set = line_of(9, LineAxis::kX);
  const Rail rail = fit_rails(set, FramePoses(9)).front();
  EXPECT_EQ(rail.stations, 0);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_LT((pose_on_rail(set, rail, i).position_m - set.frames[i].nominal_m).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace raywalk::calibrate
