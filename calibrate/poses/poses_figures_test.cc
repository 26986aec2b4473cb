#include "calibrate/poses/poses_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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
  MatchSummary summary{.motions = std::vector<RailMotion>(4, RailMotion::kAsPlanned)};
  PosesResult result{};

  SolvedGrid() {
    result.poses = start;
    for (std::size_t i = 0; i < set.frames.size(); ++i) {
      result.keyframes.push_back(i);
      result.poses[i]->observations = 100;
      result.poses[i]->residual_px = 0.5;
    }
    for (const LineCrossing& crossing : crossings) {
      result.crossings.push_back({crossing.along_x, crossing.along_z, 500});
    }
  }
  std::vector<std::string> warnings() {
    result.lines = line_figures(set, result, start);
    return pose_warnings(set, crossings, summary, result);
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

TEST(PoseWarnings, NameAReversedLine) {
  SolvedGrid grid;
  grid.forget(1);
  grid.summary.motions[1] = RailMotion::kReversed;
  EXPECT_THAT(grid.warnings(), ElementsAre(HasSubstr("line x1: its pictures move against")));
}

TEST(PoseWarnings, NameARailAtAnotherPlace) {
  SolvedGrid grid;
  for (const int frame : grid.set.lines[3].frames) {
    grid.result.poses[frame]->position_m.x() -= 1.0;
  }
  EXPECT_THAT(grid.warnings(),
              ElementsAre(HasSubstr("line z1: found 1000 mm from where it was planned")));
}

TEST(PoseWarnings, NameACrossingWithFewCommonPoints) {
  SolvedGrid grid;
  grid.result.crossings[1].points = 3;
  EXPECT_THAT(grid.warnings(),
              ElementsAre(HasSubstr("lines x0 and z1 have only 3 scene points in common")));
}

TEST(UnposedReason, NamesTheFirstCause) {
  SolvedGrid grid;
  grid.summary.features = {{0, 20}, {1, 3000}, {2, 3000}, {31, 3000}};
  grid.summary.matches = {{2, 40}};
  grid.summary.motions[1] = RailMotion::kReversed;
  EXPECT_THAT(unposed_reason(grid.set, grid.summary, 0), HasSubstr("only 20 features"));
  EXPECT_THAT(unposed_reason(grid.set, grid.summary, 1), HasSubstr("is it a picture of this"));
  EXPECT_THAT(unposed_reason(grid.set, grid.summary, 2), HasSubstr("40 matches"));
  EXPECT_THAT(unposed_reason(grid.set, grid.summary, 31), HasSubstr("against the slider"));
}

TEST(CrossingFigures, CountPointsSeenFromBothLinesNearby) {
  const SolvedGrid grid;
  // x0 crosses z0 at station 5 of both, and z1 at its station 25.
  const std::size_t z0 = 2 * 31;
  SeenPoints points;
  points.points_m.assign(3, {0, 0, 1});
  const auto see = [&](std::size_t frame, std::size_t point) {
    points.observations.push_back({frame, point});
  };
  see(4, 0);
  see(5, 0);
  see(z0 + 5, 0);
  see(4, 1);  // by x0 alone
  see(28, 2);
  see(z0 + 5, 2);  // by x0 far from the crossing
  const std::vector<CrossingPoints> figures = crossing_figures(grid.set, grid.crossings, points);
  ASSERT_EQ(figures.size(), 4U);
  EXPECT_EQ(figures[0].points, 1);
  EXPECT_EQ(figures[1].points, 0);
}

nlohmann::json document_of(const SolvedGrid& grid) {
  const TestDirectory directory;
  write_poses_report(directory.path(), grid.set, grid.result);
  return nlohmann::json::parse(read_file(directory / "poses-report.json"));
}

TEST(PosesReport, HasTheSolution) {
  SolvedGrid grid;
  grid.result.position_sigma_mm = 0.0123;
  grid.result.alignment.spread_m = {1.5, 0.75, 0.0};
  grid.result.alignment.rank = 2;
  grid.result.poses[2]->position_m.x() += 0.01;
  grid.result.poses[4].reset();
  grid.result.lines = line_figures(grid.set, grid.result, grid.start);
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
  EXPECT_EQ(document["unposed"][0]["reason"], "too plain");
  EXPECT_TRUE(document["held_out"].is_null());
  ASSERT_EQ(document["frames"].size(), 123U);
  const nlohmann::json& moved = document["frames"][2];
  EXPECT_NEAR(moved["position_m"][0].get<double>() - moved["planned_m"][0].get<double>(), 0.01,
              1e-9);
}

// Also for a grid without extent or a solution without poses.
TEST(PosesReport, IsWrittenWithNothingSolved) {
  SolvedGrid grid;
  for (CaptureFrame& frame : grid.set.frames) frame.nominal_m.setZero();
  for (int line = 0; line < 4; ++line) grid.forget(line);
  grid.set.frames.push_back({.name = "truth", .line = kHeldOut});
  grid.result.poses.emplace_back();
  grid.result.keyframes.push_back(124);
  grid.result.crossings.clear();
  const nlohmann::json document = document_of(grid);
  EXPECT_EQ(document["posed"], 0);
  EXPECT_EQ(document["held_out"]["frames"], 1);
  EXPECT_EQ(document["held_out"]["posed"], 0);
  EXPECT_TRUE(document["frames"].empty());
}

}  // namespace
}  // namespace raywalk::calibrate
