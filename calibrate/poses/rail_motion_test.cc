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

TEST(PairMotion, IsPositiveForStaticPoints) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const Eigen::Vector3d& motion :
         {Eigen::Vector3d(0.025, 0, 0), Eigen::Vector3d(0, 0, 0.025)}) {
      const auto matches = matches_between(motion, 1.5, seed);
      const PairMotion found = pair_motion(at({0, 0, 0}), at(motion), matches);
      EXPECT_GT(found.along, 10);
      EXPECT_GT(found.direction.dot(motion.normalized()), 0.97);
      EXPECT_LT(pair_motion(at({0, 0, 0}), at(-motion), matches).along, -10);
      // A list that has another axis for it.
      const PairMotion turned = pair_motion(at({0, 0, 0}), at({0, 0.025, 0}), matches);
      EXPECT_LT(std::abs(turned.along), 10);
      EXPECT_GT(turned.direction.dot(motion.normalized()), 0.97);
    }
  }
}

TEST(PairMotion, SeesAMirroredCameraAlongXOnly) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto mirrored = [&](const Eigen::Vector3d& motion) {
      std::vector<BearingMatch> matches = matches_between(motion, 1.5, seed);
      for (BearingMatch& match : matches) {
        match.in_first.x() *= -1;
        match.in_second.x() *= -1;
      }
      return pair_motion(at({0, 0, 0}), at(motion), matches).along;
    };
    EXPECT_LT(mirrored({0.025, 0, 0}), -10);
    EXPECT_GT(mirrored({0, 0, 0.025}), 10);
  }
}

TEST(PairMotion, UsesTheGivenAttitude) {
  const Eigen::Vector3d motion(0.025, 0, 0);
  std::vector<BearingMatch> matches = matches_between(motion, 1.5, 1);
  const Eigen::Matrix3d backwards = world_from_camera({kPi, 0, 0});
  for (BearingMatch& match : matches) {
    match.in_first = backwards.transpose() * match.in_first;
    match.in_second = backwards.transpose() * match.in_second;
  }
  FramePose first = at({0, 0, 0});
  FramePose second = at(motion);
  EXPECT_LT(pair_motion(first, second, matches).along, -10);
  first.world_from_camera = second.world_from_camera = backwards;
  EXPECT_GT(pair_motion(first, second, matches).along, 10);
}

TEST(PairMotion, IsWeakForDistantPoints) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Eigen::Vector3d motion(0.001, 0, 0);
    const double evidence =
        pair_motion(at({0, 0, 0}), at(motion), matches_between(motion, 500.0, seed)).along;
    EXPECT_LT(std::abs(evidence), 4.5);
  }
  EXPECT_EQ(pair_motion(at({0, 0, 0}), at({1, 0, 0}), {}).along, 0.0);
  EXPECT_EQ(pair_motion(at({0, 0, 0}), at({0, 0, 0}), matches_between({0, 0, 1}, 2, 1)).along, 0.0);
}

TEST(LineMotion, FollowsTheMajorityOfSignificantEvidence) {
  const auto along = [](const std::vector<double>& evidence) {
    std::vector<PairMotion> pairs;
    for (const double one : evidence) pairs.push_back({one, {one > 0 ? 1.0 : -1.0, 0, 0}});
    return line_motion(pairs).along;
  };
  EXPECT_EQ(along({20, 15, 1, -2, 30, -8}), RailMotion::kAsPlanned);
  EXPECT_EQ(along({-20, -15, 1, 3}), RailMotion::kReversed);
  EXPECT_EQ(along({20, -20}), RailMotion::kUnknown);
  EXPECT_EQ(along({1, -2, 0}), RailMotion::kUnknown);
  EXPECT_EQ(along({}), RailMotion::kUnknown);
  EXPECT_TRUE(line_motion({}).direction.isZero());
}

TEST(CommonFault, NamesWhatTheLinesHaveInCommon) {
  const CaptureSet set = test_grid(3);  // x0, x1, z0, z1
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), open(0, 0, 0);
  const auto fault = [&](const std::vector<Eigen::Vector3d>& directions) {
    std::vector<LineMotion> motions;
    for (const Eigen::Vector3d& direction : directions) {
      motions.push_back({RailMotion::kUnknown, direction});
    }
    return common_fault(set, motions);
  };
  EXPECT_EQ(fault({x, x, z, z}), "");
  EXPECT_EQ(fault({x, -x, z, z}), "");  // one line: its own matter
  EXPECT_EQ(fault({-x, open, open, open}), "");
  EXPECT_EQ(fault({open, open, open, open}), "");
  EXPECT_THAT(fault({-x, -x, z, z}), HasSubstr("mirrored left to right or hung upside"));
  EXPECT_THAT(fault({-x, open, z, open}), HasSubstr("mirrored left to right"));
  EXPECT_THAT(fault({-x, -x, -z, -z}), HasSubstr("looks backwards"));
  EXPECT_THAT(fault({x, x, -z, -z}), HasSubstr("mirrored and looks backwards"));
  EXPECT_THAT(fault({z, z, -x, -x}), HasSubstr("turned by 90 degrees"));
  EXPECT_THAT(fault({z, z, x, x}), HasSubstr("x and z are exchanged"));
  EXPECT_THAT(fault({x, x, y, y}), HasSubstr("y for another axis"));
  EXPECT_THAT(fault({-y, -y, z, z}), HasSubstr("y for another axis"));
}

}  // namespace
}  // namespace raywalk::calibrate
