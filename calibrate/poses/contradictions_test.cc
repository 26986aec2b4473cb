// Pictures that contradict the list: single stations, whole lines, and what all lines have in
// common.
#include "calibrate/poses/contradictions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/test_rail_scene.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kStations = 31;  // of each of four lines, 50 mm apart

std::string text_of(const std::vector<Contradiction>& found) {
  std::string text;
  for (const Contradiction& one : found) text += one.text + "\n";
  return text;
}

// A grid whose stations were solved where they were, on rails laid askew with stations that scatter
// by a third of a millimetre.
struct ListedGrid {
  CaptureSet set = test_grid(kStations);
  FramePoses truth{};
  std::mt19937 random;

  explicit ListedGrid(unsigned seed)
      : truth(test_truth(set, {.line_m = 0.02, .line_deg = 1.5, .jitter_m = 5e-4}, seed)),
        random(seed) {
    for (auto& pose : truth) {
      pose->origin = PoseOrigin::kSolved;
      pose->position_sigma_mm = 0.05;
    }
  }
  std::size_t any_frame() {
    return std::uniform_int_distribution<std::size_t>(0, set.frames.size() - 1)(random);
  }
  std::vector<Contradiction> contradictions() const {
    return contradictions_of(set, truth, fit_rails(set, truth));
  }
  // The only one that there is.
  Contradiction contradiction() const {
    const std::vector<Contradiction> found = contradictions();
    EXPECT_EQ(found.size(), 1U) << text_of(found);
    return found.empty() ? Contradiction{} : found.front();
  }
};

TEST(Contradictions, AreNotInvented) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const auto found = ListedGrid(seed).contradictions();
    EXPECT_THAT(found, IsEmpty()) << seed << ": " << text_of(found);
  }
}

TEST(Contradictions, NameExchangedStations) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    ListedGrid grid(seed);
    const std::size_t a = grid.any_frame();
    std::size_t b = grid.any_frame();
    while (b == a) b = grid.any_frame();
    std::swap(grid.truth[a], grid.truth[b]);
    const Contradiction found = grid.contradiction();
    EXPECT_EQ(found.kind, "exchanged");
    EXPECT_THAT(found.frames, ElementsAre(std::min(a, b), std::max(a, b)));
    EXPECT_THAT(found.text,
                AllOf(HasSubstr(grid.set.frames[a].name), HasSubstr(grid.set.frames[b].name)));
    // The picture of one was matched where it is listed, so it could not be solved.
    grid.truth[b]->origin = PoseOrigin::kRail;
    const Contradiction half = grid.contradiction();
    EXPECT_EQ(half.kind, "exchanged");
    EXPECT_THAT(half.frames, ElementsAre(a, b));
  }
}

// From about six standard deviations of the scatter up.
TEST(Contradictions, NameAStationThatLiesElsewhere) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    ListedGrid grid(seed);
    const std::size_t frame = grid.any_frame();
    const double off_m = 0.003 * std::pow(1.5, seed);
    const Eigen::Vector3d off = off_m * random_vector(&grid.random, 1.0).normalized();
    grid.truth[frame]->position_m += off;
    const Contradiction found = grid.contradiction();
    EXPECT_EQ(found.kind, "off");
    EXPECT_THAT(found.frames, ElementsAre(frame));
    EXPECT_THAT(found.text, HasSubstr(grid.set.frames[frame].name + " lies"));
  }
}

TEST(Contradictions, NameAPictureThatIsMissingOrThereTwice) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    ListedGrid grid(seed);
    const int line = static_cast<int>(seed % 4);
    const auto& frames = grid.set.lines[line].frames;
    const std::size_t first = 4 + 2 * seed;
    const bool missing = seed % 2 == 0;
    const FramePoses truth = grid.truth;
    const Eigen::Vector3d step =
        (truth[frames.back()]->position_m - truth[frames.front()]->position_m) / (kStations - 1);
    for (std::size_t i = first; i < frames.size(); ++i) {
      grid.truth[frames[i]]->position_m += missing ? step : Eigen::Vector3d(-step);
    }
    const Contradiction found = grid.contradiction();
    EXPECT_EQ(found.kind, "shifted");
    EXPECT_EQ(found.frames.at(0), frames[first]);
    EXPECT_THAT(found.text, HasSubstr(missing ? "is missing" : "is there twice"));
  }
}

TEST(Contradictions, NameALineListedTooLongOrTooShort) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    ListedGrid grid(seed);
    const double stretch = seed % 2 == 0 ? 1.0 + 0.015 * seed : 1.0 - 0.015 * seed;
    const auto& frames = grid.set.lines[seed % 4].frames;
    const Eigen::Vector3d middle_m = grid.truth[frames[kStations / 2]]->position_m;
    for (const int frame : frames) {
      Eigen::Vector3d& at_m = grid.truth[frame]->position_m;
      at_m = middle_m + stretch * (at_m - middle_m);
    }
    const Contradiction found = grid.contradiction();
    EXPECT_EQ(found.kind, "stretched");
    EXPECT_THAT(found.text, HasSubstr(stretch > 1.0 ? "longer" : "shorter"));
  }
}

// Four stations at 0, 0.01, 1.0 and 2.9 m that the list has at equal steps.
TEST(Contradictions, NameALineThatWasNotTakenAsListed) {
  CaptureSet set = test_line(4, 1.5);
  FramePoses poses = nominal_poses(set);
  const std::array found_m{0.0, 0.01, 1.0, 2.9};
  for (std::size_t i = 0; i < 4; ++i) {
    poses[i]->position_m.x() = found_m[i];
    poses[i]->origin = PoseOrigin::kSolved;
    poses[i]->position_sigma_mm = 1.0;
  }
  const auto found = contradictions_of(set, poses, fit_rails(set, poses));
  ASSERT_EQ(found.size(), 1U) << text_of(found);
  EXPECT_EQ(found[0].kind, "scattered");
  EXPECT_EQ(found[0].frames.size(), 4U);
  EXPECT_THAT(found[0].text, HasSubstr("not where they are listed"));
}

TEST(Contradictions, NeedSolvedPoses) {
  ListedGrid grid(1);
  for (auto& pose : grid.truth) {
    pose->position_m += Eigen::Vector3d(0, 0.1 * (pose->position_m.x() > 0), 0);
    pose->origin = PoseOrigin::kRail;
  }
  EXPECT_THAT(grid.contradictions(), IsEmpty());
}

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
  EXPECT_THAT(fault({x, x, -z, -z}), HasSubstr("mirrored and looks backwards"));
  EXPECT_THAT(fault({x, x, y, y}), HasSubstr("y for another axis"));
  EXPECT_THAT(fault({-y, -y, z, z}), HasSubstr("y for another axis"));
}

}  // namespace
}  // namespace raywalk::calibrate
