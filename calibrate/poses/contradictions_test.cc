#include "calibrate/poses/contradictions.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <random>

#include "calibrate/poses/intersection_check.h"
#include "calibrate/poses/pose_accuracy.h"
#include "calibrate/poses/poses_document.h"
#include "calibrate/poses/poses_figures.h"
#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/test_rail_scene.h"
#include "core/files/atomic_output.h"
#include "core/files/test_json.h"
#include "core/files/test_support.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

// --- Pictures that contradict the list: single stations, whole lines, what all have in common ---

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
    grid.truth[frame]->position_m += off_m * random_vector(&grid.random, 1.0).normalized();
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
  const CaptureSet set = test_line(4, 1.5);
  FramePoses poses;
  for (const double found_m : {0.0, 0.01, 1.0, 2.9}) {
    poses.push_back(FramePose{
        .position_m = {found_m, 0, 0}, .origin = PoseOrigin::kSolved, .position_sigma_mm = 1.0});
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

FramePose at(const Eigen::Vector3d& position_m) { return {.position_m = position_m}; }

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
    match = {backwards.transpose() * match.in_first, backwards.transpose() * match.in_second};
  }
  FramePose first = at({0, 0, 0}), second = at(motion);
  EXPECT_LT(pair_motion(first, second, matches).along, -10);
  first.world_from_camera = second.world_from_camera = backwards;
  EXPECT_GT(pair_motion(first, second, matches).along, 10);
}

TEST(PairMotion, IsWeakForDistantPoints) {
  const Eigen::Vector3d motion(0.001, 0, 0);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto matches = matches_between(motion, 500.0, seed);
    EXPECT_LT(std::abs(pair_motion(at({0, 0, 0}), at(motion), matches).along), 4.5);
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

// --- The intersections ---------------------------------------------------------------------------

constexpr double kNoise_px = 0.4;

struct CheckedGrid {
  CaptureSet set{};
  std::vector<LineIntersection> intersections{};
  FramePoses poses{};
  DividedPoints points{};

  explicit CheckedGrid(unsigned seed, double scale = 1.0) : set(test_grid(13, scale)) {
    intersections = intersections_of(set);
    poses = test_truth(set, {.line_m = 0.02 * scale, .jitter_m = 1e-3 * scale}, seed);
    points = divide_points(set, intersections,
                           test_points(set, poses, 3000, scale, kNoise_px, seed + 100));
    for (auto& pose : poses) {
      pose->position_sigma_mm = 1e-3 * scale;
      pose->rotation_sigma_deg = 1e-4;
    }
  }
  void move(int line, const Eigen::Vector3d& by_m, const Eigen::Vector3d& turn_rad) {
    for (const int frame : set.lines[line].frames) {
      FramePose& pose = *poses[frame];
      pose.position_m = matrix_of(turn_rad) * pose.position_m + by_m;
      pose.world_from_camera = matrix_of(turn_rad) * pose.world_from_camera;
    }
  }
  std::vector<IntersectionCheck> checks() const {
    return check_intersections(set, intersections, poses, kNoise_px, points.held_out);
  }
};

TEST(DividePoints, HoldsOutHalfOfThePointsThatConnectLines) {
  const CheckedGrid grid(1);
  const std::size_t held = grid.points.held_out.points_m.size();
  const std::size_t used = grid.points.used.points_m.size();
  EXPECT_EQ(held + used, 3000U);
  EXPECT_GT(held, 300U);
  EXPECT_LT(held, used);
}

// What the points ask for is within its own sigmas: the mean of the squares of three components
// over their variances is 1.
TEST(CheckIntersections, FindsNothingAtTrueAndItsSigmasAreRight) {
  double square = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const CheckedGrid grid(seed);
    for (const IntersectionCheck& check : grid.checks()) {
      EXPECT_THAT(intersection_faults(grid.set, check, 0.125), IsEmpty()) << seed;
      const Eigen::Matrix3d position = check.covariance.topLeftCorner<3, 3>();
      square += check.motion_m.dot(position.inverse() * check.motion_m) / 3.0;
      ++count;
    }
  }
  EXPECT_EQ(count, 32);
  EXPECT_NEAR(square / count, 1.0, 0.35);
}

TEST(CheckIntersections, MeasuresHowALineDisagrees) {
  for (const double scale : {1e-2, 1.0, 1e2}) {
    CheckedGrid grid(2, scale);
    const Eigen::Vector3d by_m = scale * Eigen::Vector3d(0.004, 0.006, -0.003);
    grid.move(0, by_m, {0.0, 0.002, 0.0});
    for (const IntersectionCheck& check : grid.checks()) {
      const bool moved = check.intersection.along_x == 0;
      // The points ask for the way back.
      EXPECT_NEAR(check.rotation_rad.y(), moved ? -0.002 : 0.0, 2e-4);
      EXPECT_NEAR(check.motion_m.y(), moved ? -by_m.y() : 0.0, 8e-4 * scale);
      const auto faults = intersection_faults(grid.set, check, 0.125 * scale);
      EXPECT_EQ(faults.empty(), !moved);
      if (moved) {
        EXPECT_THAT(faults, ElementsAre(AllOf(HasSubstr("lines x0 and z"), HasSubstr("rotation")),
                                        HasSubstr("displacement")));
      }
    }
  }
}

TEST(CheckIntersections, NamesLinesWithoutCommonPoints) {
  CheckedGrid grid(3);
  for (const int frame : grid.set.lines[2].frames) grid.poses[frame].reset();
  for (const IntersectionCheck& check : grid.checks()) {
    const bool blind = check.intersection.along_z == 2;
    EXPECT_EQ(check.points == 0, blind);
    if (blind) {
      EXPECT_THAT(intersection_faults(grid.set, check, 0.125),
                  ElementsAre(HasSubstr("only 0 held-out scene points")));
    }
  }
}

TEST(CheckIntersections, SaysWhenItCannotTell) {
  CheckedGrid grid(4);
  for (auto& pose : grid.poses) pose->rotation_sigma_deg = 0.5;
  EXPECT_THAT(intersection_faults(grid.set, grid.checks().front(), 0.125),
              ElementsAre(HasSubstr("too coarsely for a check")));
}

// --- Warnings and the document -------------------------------------------------------------------

// x0, x1, z0, z1 with stations 50 mm apart, all solved where they were planned.
class SolvedGrid : public ::testing::Test {
 protected:
  CaptureSet set_ = test_grid(31);
  FramePoses start_ = nominal_poses(set_);
  std::vector<LineIntersection> intersections_ = intersections_of(set_);
  MatchSummary summary_{};
  PosesResult result_{};

  SolvedGrid() {
    result_.poses = start_;
    for (auto& pose : result_.poses) pose->origin = PoseOrigin::kSolved;
    for (std::size_t i = 0; i < set_.frames.size(); ++i) {
      result_.keyframes.push_back(i);
      result_.poses[i]->observations = 100;
      result_.poses[i]->residual_px = 0.5;
    }
    for (const LineIntersection& intersection : intersections_) {
      result_.intersections.push_back({.check = {.intersection = intersection, .points = 500}});
    }
  }
  std::vector<std::string> warnings() {
    result_.lines = line_figures(set_, result_, start_);
    result_.rails = fit_rails(set_, result_.poses);
    result_.warnings.clear();
    add_warnings(set_, &result_);
    return result_.warnings;
  }
  nlohmann::json document() const {
    const TestDirectory directory;
    write_poses(directory / "poses.json", set_, result_);
    return nlohmann::json::parse(read_file(directory / "poses.json"));
  }
  void forget(int line) {
    for (const int frame : set_.lines[line].frames) result_.poses[frame].reset();
  }
};

TEST_F(SolvedGrid, WarningsNameAnUnconnectedLine) {
  forget(2);
  EXPECT_THAT(warnings(), ElementsAre(AllOf(HasSubstr("line z0: nothing in its pictures"),
                                            HasSubstr("Was the rail laid"))));
}

TEST_F(SolvedGrid, WarningsNameContradictionsAndTheFaultsOfIntersections) {
  result_.contradictions = {{"off", {3}, "x0_3 lies elsewhere"}};
  result_.intersections[1].faults = {"lines x0 and z1: apart"};
  EXPECT_THAT(warnings(), UnorderedElementsAre(AllOf(HasSubstr("x0_3 lies elsewhere"),
                                                     HasSubstr("correct the positions")),
                                               "lines x0 and z1: apart"));
  EXPECT_FALSE(result_.trustworthy());
}

// Keyframes without a pose are doubtful where they are many; stations between keyframes are not.
TEST_F(SolvedGrid, WarningsNameALineThatIsMostlyPredicted) {
  const auto& frames = set_.lines[0].frames;
  for (const int frame : {2, 3}) result_.poses[frames[frame]].reset();
  EXPECT_THAT(warnings(), IsEmpty());
  EXPECT_THAT(result_.notes, testing::Contains(AllOf(HasSubstr("line x0: 2 of 31 stations"),
                                                     HasSubstr("2 of 31 keyframes"))));
  for (int i = 4; i < 12; ++i) result_.poses[frames[i]].reset();
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("line x0: 10 of 31 stations")));
}

TEST_F(SolvedGrid, WarningsNameLinesThatNoneCrosses) {
  std::erase_if(result_.intersections, [](const MeasuredIntersection& intersection) {
    return intersection.check.intersection.along_x == 1;
  });
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("line x1: no line crosses it")));
}

TEST_F(SolvedGrid, WarningsNameARailAtAnotherPlace) {
  for (const int frame : set_.lines[3].frames) result_.poses[frame]->position_m.x() -= 1.0;
  EXPECT_THAT(warnings(),
              ElementsAre(AllOf(HasSubstr("line z1: found 1000 mm from where it was planned"),
                                HasSubstr("nearer to the place of line z0"))));
}

TEST_F(SolvedGrid, UnposedReasonNamesTheFirstCause) {
  summary_.features = {{0, 20}, {1, 3000}, {2, 3000}, {31, 3000}};
  summary_.matches = {{2, 40}};
  EXPECT_THAT(unposed_reason(set_, summary_, 0), HasSubstr("only 20 features"));
  EXPECT_THAT(unposed_reason(set_, summary_, 1), HasSubstr("is it a picture of this"));
  EXPECT_THAT(unposed_reason(set_, summary_, 2), HasSubstr("40 matches"));
}

TEST_F(SolvedGrid, CorrectionIsThatOfTheStationsNearestToTheIntersection) {
  for (const int frame : set_.lines[0].frames) {
    result_.poses[frame]->position_m += Eigen::Vector3d(0, 0.003, 0.004);
    result_.poses[frame]->world_from_camera = world_from_camera({0.01, 0, 0});
  }
  for (MeasuredIntersection& intersection : result_.intersections) {
    set_correction(set_, start_, result_.poses, &intersection);
    const bool moved = intersection.check.intersection.along_x == 0;
    EXPECT_NEAR(intersection.correction_mm, moved ? 5.0 : 0.0, 1e-9);
    EXPECT_NEAR(intersection.correction_deg, moved ? degrees_from_radians(0.01) : 0.0, 1e-6);
  }
}

TEST_F(SolvedGrid, DocumentHasTheSolutionAndSumsUpTheStationsOfLines) {
  result_.position_sigma_mm = 0.0123;
  result_.alignment.spread_m = {1.5, 0.75, 0.0};
  result_.alignment.rank = 2;
  result_.poses[2]->position_m += Eigen::Vector3d(0.006, 0, 0.008);
  result_.poses[4].reset();
  result_.poses[5]->world_from_camera = world_from_camera({0.01, 0, 0});
  result_.poses[9]->residual_px = 2.0;
  warnings();
  result_.contradictions = {{"off", {2}, "x0_2 lies elsewhere"}};
  result_.times = {{"faces", 1.5, true}, {"features", 41.0, false}};
  result_.unposed = {{4, "too plain"}};
  const nlohmann::json document = this->document();
  expect_keys(document, {{"stations", 124}, {"posed", 123}, {"position_sigma_mm", 0.0123}});
  expect_keys(document, {{"total_seconds", 42.5}});
  EXPECT_EQ(document["seconds"][0]["reused"], true);
  EXPECT_EQ(document["alignment"]["spread_m"], (std::vector<double>{1.5, 0.75, 0.0}));
  EXPECT_EQ(document["alignment"]["rotation_from"],
            "stations in a plane: the rotation is from positions");
  const nlohmann::json &line = document["lines"][0], &other = document["lines"][1];
  expect_keys(line, {{"stations", 31}, {"keyframes", 31}, {"posed", 30}, {"observations", 3000}});
  EXPECT_NEAR(line["moved_mm"].get<double>(), 10.0, 1e-9);
  EXPECT_NEAR(line["turned_deg"].get<double>(), degrees_from_radians(0.01), 1e-6);
  EXPECT_NEAR(line["residual_px"].get<double>(), std::sqrt((29 * 0.25 + 4.0) / 30.0), 1e-9);
  EXPECT_NEAR(line["deviations"][2]["along_mm"].get<double>(), 6.0, 0.1);
  EXPECT_EQ(other["moved_mm"], 0.0);
  EXPECT_EQ(document["contradictions"][0]["stations"][0], set_.frames[2].name);
  expect_keys(document["intersections"][0], {{"held_out_points", 500}, {"position_mm", 0.0}});
  EXPECT_EQ(document["unposed"][0]["reason"], "too plain");
  ASSERT_EQ(document["frames"].size(), 123U);
  const nlohmann::json& moved = document["frames"][2];
  EXPECT_NEAR(moved["position_m"][0].get<double>() - moved["planned_m"][0].get<double>(), 0.006,
              1e-9);
}

// Also for a grid without extent or a solution without poses.
TEST_F(SolvedGrid, DocumentIsWrittenWithNothingSolved) {
  for (CaptureFrame& frame : set_.frames) frame.nominal_m.setZero();
  for (int line = 0; line < 4; ++line) forget(line);
  set_.frames.push_back({.name = "truth", .line = kHeldOut});
  result_.poses.emplace_back();
  result_.keyframes.push_back(124);
  result_.intersections.clear();
  warnings();
  const nlohmann::json document = this->document();
  EXPECT_EQ(document["posed"], 0);
  expect_keys(document["held_out"], {{"frames", 1}, {"posed", 0}});
  EXPECT_TRUE(document["frames"].empty());
}

}  // namespace
}  // namespace raywalk::calibrate
