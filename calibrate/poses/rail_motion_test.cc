#include "calibrate/poses/rail_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/poses/test_rail_scene.h"

namespace raywalk::calibrate {
namespace {

using ::testing::HasSubstr;

// Points around two stations 25 mm apart, with a noise of a pixel and a tenth of wrong matches. The
// cameras are rotated by a degree from their assumed attitudes.
std::vector<BearingMatch> matches_between(const Eigen::Vector3d& motion_m, double distance_m,
                                          unsigned seed) {
  std::mt19937 random(seed);
  const Eigen::Matrix3d turn = random_turn(&random, 1.0);
  std::vector<BearingMatch> matches;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d point =
        distance_m * (1.0 + 0.02 * (i % 100)) * random_vector(&random, 1.0).normalized();
    const Eigen::Vector3d error = random_vector(&random, 1.0 / kResidualPx_per_rad);
    BearingMatch match{point.normalized(),
                       turn * ((point - motion_m).normalized() + error).normalized()};
    if (i % 10 == 0) match.in_second = (match.in_second + random_vector(&random, 0.1)).normalized();
    matches.push_back(match);
  }
  return matches;
}

FramePose at(const Eigen::Vector3d& position_m) {
  FramePose pose;
  pose.position_m = position_m;
  return pose;
}

TEST(MotionEvidence, IsPositiveForStaticPoints) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const Eigen::Vector3d& motion :
         {Eigen::Vector3d(0.025, 0, 0), Eigen::Vector3d(0, 0, 0.025)}) {
      EXPECT_GT(motion_evidence(at({0, 0, 0}), at(motion), matches_between(motion, 1.5, seed)), 10);
      EXPECT_LT(motion_evidence(at({0, 0, 0}), at(-motion), matches_between(motion, 1.5, seed)),
                -10);
    }
  }
}

TEST(MotionEvidence, SeesAMirroredCameraAlongXOnly) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto mirrored = [&](const Eigen::Vector3d& motion) {
      std::vector<BearingMatch> matches = matches_between(motion, 1.5, seed);
      for (BearingMatch& match : matches) {
        match.in_first.x() *= -1;
        match.in_second.x() *= -1;
      }
      return motion_evidence(at({0, 0, 0}), at(motion), matches);
    };
    EXPECT_LT(mirrored({0.025, 0, 0}), -10);
    EXPECT_GT(mirrored({0, 0, 0.025}), 10);
  }
}

TEST(MotionEvidence, UsesTheGivenAttitude) {
  const Eigen::Vector3d motion(0.025, 0, 0);
  std::vector<BearingMatch> matches = matches_between(motion, 1.5, 1);
  const Eigen::Matrix3d backwards = world_from_camera({kPi, 0, 0});
  for (BearingMatch& match : matches) {
    match.in_first = backwards.transpose() * match.in_first;
    match.in_second = backwards.transpose() * match.in_second;
  }
  FramePose first = at({0, 0, 0});
  FramePose second = at(motion);
  EXPECT_LT(motion_evidence(first, second, matches), -10);
  first.world_from_camera = second.world_from_camera = backwards;
  EXPECT_GT(motion_evidence(first, second, matches), 10);
}

TEST(MotionEvidence, IsWeakForDistantPoints) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Eigen::Vector3d motion(0.001, 0, 0);
    const double evidence =
        motion_evidence(at({0, 0, 0}), at(motion), matches_between(motion, 500.0, seed));
    EXPECT_LT(std::abs(evidence), 4.5);
  }
  EXPECT_EQ(motion_evidence(at({0, 0, 0}), at({1, 0, 0}), {}), 0.0);
  EXPECT_EQ(motion_evidence(at({0, 0, 0}), at({0, 0, 0}), matches_between({0, 0, 1}, 2, 1)), 0.0);
}

TEST(RailMotion, FollowsTheMajorityOfSignificantEvidence) {
  const std::vector<double> mostly{20, 15, 1, -2, 30, -8};
  EXPECT_EQ(rail_motion(mostly), RailMotion::kAsPlanned);
  const std::vector<double> against{-20, -15, 1, 3};
  EXPECT_EQ(rail_motion(against), RailMotion::kReversed);
  const std::vector<double> torn{20, -20};
  EXPECT_EQ(rail_motion(torn), RailMotion::kUnknown);
  const std::vector<double> unsure{1, -2, 0};
  EXPECT_EQ(rail_motion(unsure), RailMotion::kUnknown);
  EXPECT_EQ(rail_motion({}), RailMotion::kUnknown);
}

TEST(CommonFault, NamesWhatTheLinesHaveInCommon) {
  const CaptureSet set = test_grid(3);  // x0, x1, z0, z1
  constexpr RailMotion kYes = RailMotion::kAsPlanned;
  constexpr RailMotion kNo = RailMotion::kReversed;
  constexpr RailMotion kOpen = RailMotion::kUnknown;
  const auto fault = [&](const std::vector<RailMotion>& motions) {
    return common_fault(set, motions);
  };
  EXPECT_EQ(fault({kYes, kYes, kYes, kYes}), "");
  EXPECT_EQ(fault({kYes, kNo, kYes, kYes}), "");  // one line: its own matter
  EXPECT_EQ(fault({kOpen, kOpen, kOpen, kOpen}), "");
  EXPECT_THAT(fault({kNo, kNo, kYes, kYes}), HasSubstr("mirrored left to right or hung upside"));
  EXPECT_THAT(fault({kNo, kOpen, kYes, kOpen}), HasSubstr("mirrored left to right"));
  EXPECT_THAT(fault({kNo, kNo, kNo, kNo}), HasSubstr("looks backwards"));
  EXPECT_THAT(fault({kYes, kYes, kNo, kNo}), HasSubstr("mirrored and looks backwards"));
}

}  // namespace
}  // namespace raywalk::calibrate
