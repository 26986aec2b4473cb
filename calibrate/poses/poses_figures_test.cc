#include "calibrate/poses/poses_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibrate/poses/poses_document.h"
#include "calibrate/poses/test_rail_scene.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// x0, x1, z0, z1 with stations 50 mm apart, all solved where they were planned.
struct SolvedGrid {
  CaptureSet set = test_grid(31);
  FramePoses start = nominal_poses(set);
  std::vector<LineCrossing> crossings = crossings_of(set);
  MatchSummary summary{};
  PosesResult result{};

  SolvedGrid() {
    result.poses = start;
    for (auto& pose : result.poses) pose->origin = PoseOrigin::kSolved;
    for (std::size_t i = 0; i < set.frames.size(); ++i) {
      result.keyframes.push_back(i);
      result.poses[i]->observations = 100;
      result.poses[i]->residual_px = 0.5;
    }
    for (const LineCrossing& crossing : crossings) {
      result.crossings.push_back({.check = {.crossing = crossing, .points = 500}});
    }
  }
  std::vector<std::string> warnings() {
    result.lines = line_figures(set, result, start);
    result.rails = fit_rails(set, result.poses);
    result.warnings.clear();
    add_warnings(set, &result);
    return result.warnings;
  }
  void forget(int line) {
    for (const int frame : set.lines[line].frames) result.poses[frame].reset();
  }
};

TEST(LineFigures, SumUpTheStations) {
  SolvedGrid grid;
  grid.result.poses[3]->position_m += Eigen::Vector3d(0.003, 0, 0.004);
  grid.result.poses[5]->world_from_camera = world_from_camera({0.01, 0, 0});
  grid.result.poses[7].reset();
  grid.result.poses[9]->residual_px = 2.0;
  const std::vector<LinePoses> lines = line_figures(grid.set, grid.result, grid.start);
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0].stations, 31);
  EXPECT_EQ(lines[0].keyframes, 31);
  EXPECT_EQ(lines[0].posed, 30);
  EXPECT_EQ(lines[0].observations, 3000);
  EXPECT_NEAR(lines[0].moved_mm, 5.0, 1e-9);
  EXPECT_NEAR(lines[0].turned_deg, degrees_from_radians(0.01), 1e-6);
  EXPECT_NEAR(lines[0].residual_px, std::sqrt((29 * 0.25 + 4.0) / 30.0), 1e-9);
  EXPECT_EQ(lines[1].moved_mm, 0.0);
}

TEST(PoseWarnings, AreEmptyForGoodPoses) { EXPECT_THAT(SolvedGrid().warnings(), IsEmpty()); }

TEST(PoseWarnings, NameAnUnconnectedLine) {
  SolvedGrid grid;
  grid.forget(2);
  EXPECT_THAT(grid.warnings(), ElementsAre(AllOf(HasSubstr("line z0: nothing in its pictures"),
                                                 HasSubstr("Was the rail laid"))));
}

TEST(PoseWarnings, NameContradictions) {
  SolvedGrid grid;
  grid.result.contradictions = {{"off", {3}, "x0_3 lies elsewhere"}};
  EXPECT_THAT(grid.warnings(), ElementsAre(AllOf(HasSubstr("x0_3 lies elsewhere"),
                                                 HasSubstr("correct the positions"))));
  EXPECT_FALSE(grid.result.trustworthy());
}

// Keyframes without a pose are doubtful where they are many; stations between keyframes are not.
TEST(PoseWarnings, NameALineThatIsMostlyPredicted) {
  SolvedGrid grid;
  const auto& frames = grid.set.lines[0].frames;
  for (const int frame : {2, 3}) grid.result.poses[frames[frame]].reset();
  EXPECT_THAT(grid.warnings(), IsEmpty());
  EXPECT_THAT(grid.result.notes, Contains(AllOf(HasSubstr("line x0: 2 of 31 stations"),
                                                HasSubstr("2 of 31 keyframes"))));
  for (int i = 4; i < 12; ++i) grid.result.poses[frames[i]].reset();
  EXPECT_THAT(grid.warnings(), ElementsAre(HasSubstr("line x0: 10 of 31 stations")));
}

TEST(PoseWarnings, NameLinesThatNoneCrosses) {
  SolvedGrid grid;
  std::erase_if(grid.result.crossings, [](const MeasuredCrossing& crossing) {
    return crossing.check.crossing.along_x == 1;
  });
  EXPECT_THAT(grid.warnings(), ElementsAre(HasSubstr("line x1: no line crosses it")));
}

TEST(PoseWarnings, NameARailAtAnotherPlace) {
  SolvedGrid grid;
  for (const int frame : grid.set.lines[3].frames) {
    grid.result.poses[frame]->position_m.x() -= 1.0;
  }
  EXPECT_THAT(grid.warnings(),
              ElementsAre(AllOf(HasSubstr("line z1: found 1000 mm from where it was planned"),
                                HasSubstr("nearer to the place of line z0"))));
}

TEST(PoseWarnings, NameTheFaultsOfCrossings) {
  SolvedGrid grid;
  grid.result.crossings[1].faults = {"lines x0 and z1: apart"};
  EXPECT_THAT(grid.warnings(), ElementsAre("lines x0 and z1: apart"));
}

TEST(UnposedReason, NamesTheFirstCause) {
  SolvedGrid grid;
  grid.summary.features = {{0, 20}, {1, 3000}, {2, 3000}, {31, 3000}};
  grid.summary.matches = {{2, 40}};
  EXPECT_THAT(unposed_reason(grid.set, grid.summary, 0), HasSubstr("only 20 features"));
  EXPECT_THAT(unposed_reason(grid.set, grid.summary, 1), HasSubstr("is it a picture of this"));
  EXPECT_THAT(unposed_reason(grid.set, grid.summary, 2), HasSubstr("40 matches"));
}

nlohmann::json document_of(const SolvedGrid& grid) {
  const TestDirectory directory;
  write_poses(directory / "poses.json", grid.set, grid.result);
  return nlohmann::json::parse(read_file(directory / "poses.json"));
}

TEST(SetCorrection, IsThatOfTheStationsNearestToTheCrossing) {
  SolvedGrid grid;
  for (const int frame : grid.set.lines[0].frames) {
    grid.result.poses[frame]->position_m += Eigen::Vector3d(0, 0.003, 0.004);
    grid.result.poses[frame]->world_from_camera = world_from_camera({0.01, 0, 0});
  }
  for (MeasuredCrossing& crossing : grid.result.crossings) {
    set_correction(grid.set, grid.start, grid.result.poses, &crossing);
    const bool moved = crossing.check.crossing.along_x == 0;
    EXPECT_NEAR(crossing.correction_mm, moved ? 5.0 : 0.0, 1e-9);
    EXPECT_NEAR(crossing.correction_deg, moved ? degrees_from_radians(0.01) : 0.0, 1e-6);
  }
}

TEST(PosesDocument, HasTheSolution) {
  SolvedGrid grid;
  grid.result.position_sigma_mm = 0.0123;
  grid.result.alignment.spread_m = {1.5, 0.75, 0.0};
  grid.result.alignment.rank = 2;
  grid.result.poses[2]->position_m.x() += 0.01;
  grid.result.poses[4].reset();
  grid.warnings();
  grid.result.contradictions = {{"off", {2}, "x0_2 lies elsewhere"}};
  grid.result.times = {{"faces", 1.5, true}, {"features", 41.0, false}};
  grid.result.unposed = {{4, "too plain"}};
  const nlohmann::json document = document_of(grid);
  EXPECT_EQ(document["stations"], 124);
  EXPECT_EQ(document["posed"], 123);
  EXPECT_EQ(document["position_sigma_mm"], 0.0123);
  EXPECT_EQ(document["total_seconds"], 42.5);
  EXPECT_EQ(document["seconds"][0]["reused"], true);
  EXPECT_EQ(document["alignment"]["spread_m"], (std::vector<double>{1.5, 0.75, 0.0}));
  EXPECT_EQ(document["alignment"]["rotation_from"],
            "stations in a plane: the rotation is from positions");
  EXPECT_EQ(document["lines"][0]["posed"], 30);
  EXPECT_EQ(document["lines"][0]["observations"], 3000);
  EXPECT_NEAR(document["lines"][0]["moved_mm"].get<double>(), 10.0, 1e-9);
  EXPECT_NEAR(document["lines"][0]["deviations"][2]["along_mm"].get<double>(), 10.0, 0.1);
  EXPECT_EQ(document["contradictions"][0]["stations"][0], grid.set.frames[2].name);
  EXPECT_EQ(document["crossings"][0]["held_out_points"], 500);
  EXPECT_EQ(document["crossings"][0]["position_mm"], 0.0);
  EXPECT_EQ(document["trustworthy"], true);
  EXPECT_EQ(document["unposed"][0]["reason"], "too plain");
  EXPECT_TRUE(document["held_out"].is_null());
  ASSERT_EQ(document["frames"].size(), 123U);
  const nlohmann::json& moved = document["frames"][2];
  EXPECT_NEAR(moved["position_m"][0].get<double>() - moved["planned_m"][0].get<double>(), 0.01,
              1e-9);
}

// Also for a grid without extent or a solution without poses.
TEST(PosesDocument, IsWrittenWithNothingSolved) {
  SolvedGrid grid;
  for (CaptureFrame& frame : grid.set.frames) frame.nominal_m.setZero();
  for (int line = 0; line < 4; ++line) grid.forget(line);
  grid.set.frames.push_back({.name = "truth", .line = kHeldOut});
  grid.result.poses.emplace_back();
  grid.result.keyframes.push_back(124);
  grid.result.crossings.clear();
  grid.warnings();
  const nlohmann::json document = document_of(grid);
  EXPECT_EQ(document["posed"], 0);
  EXPECT_EQ(document["held_out"]["frames"], 1);
  EXPECT_EQ(document["held_out"]["posed"], 0);
  EXPECT_TRUE(document["frames"].empty());
}

}  // namespace
}  // namespace raywalk::calibrate
