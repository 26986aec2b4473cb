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
class SolvedGrid : public ::testing::Test {
 protected:
  CaptureSet set_ = test_grid(31);
  FramePoses start_ = nominal_poses(set_);
  std::vector<LineCrossing> crossings_ = crossings_of(set_);
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
    for (const LineCrossing& crossing : crossings_) {
      result_.crossings.push_back({.check = {.crossing = crossing, .points = 500}});
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

TEST_F(SolvedGrid, LineFiguresSumUpTheStations) {
  result_.poses[3]->position_m += Eigen::Vector3d(0.003, 0, 0.004);
  result_.poses[5]->world_from_camera = world_from_camera({0.01, 0, 0});
  result_.poses[7].reset();
  result_.poses[9]->residual_px = 2.0;
  const std::vector<LinePoses> lines = line_figures(set_, result_, start_);
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

TEST_F(SolvedGrid, HasNoWarnings) { EXPECT_THAT(warnings(), IsEmpty()); }

TEST_F(SolvedGrid, WarningsNameAnUnconnectedLine) {
  forget(2);
  EXPECT_THAT(warnings(), ElementsAre(AllOf(HasSubstr("line z0: nothing in its pictures"),
                                            HasSubstr("Was the rail laid"))));
}

TEST_F(SolvedGrid, WarningsNameContradictions) {
  result_.contradictions = {{"off", {3}, "x0_3 lies elsewhere"}};
  EXPECT_THAT(warnings(), ElementsAre(AllOf(HasSubstr("x0_3 lies elsewhere"),
                                            HasSubstr("correct the positions"))));
  EXPECT_FALSE(result_.trustworthy());
}

// Keyframes without a pose are doubtful where they are many; stations between keyframes are not.
TEST_F(SolvedGrid, WarningsNameALineThatIsMostlyPredicted) {
  const auto& frames = set_.lines[0].frames;
  for (const int frame : {2, 3}) result_.poses[frames[frame]].reset();
  EXPECT_THAT(warnings(), IsEmpty());
  EXPECT_THAT(result_.notes, Contains(AllOf(HasSubstr("line x0: 2 of 31 stations"),
                                            HasSubstr("2 of 31 keyframes"))));
  for (int i = 4; i < 12; ++i) result_.poses[frames[i]].reset();
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("line x0: 10 of 31 stations")));
}

TEST_F(SolvedGrid, WarningsNameLinesThatNoneCrosses) {
  std::erase_if(result_.crossings, [](const MeasuredCrossing& crossing) {
    return crossing.check.crossing.along_x == 1;
  });
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("line x1: no line crosses it")));
}

TEST_F(SolvedGrid, WarningsNameARailAtAnotherPlace) {
  for (const int frame : set_.lines[3].frames) {
    result_.poses[frame]->position_m.x() -= 1.0;
  }
  EXPECT_THAT(warnings(),
              ElementsAre(AllOf(HasSubstr("line z1: found 1000 mm from where it was planned"),
                                HasSubstr("nearer to the place of line z0"))));
}

TEST_F(SolvedGrid, WarningsNameTheFaultsOfCrossings) {
  result_.crossings[1].faults = {"lines x0 and z1: apart"};
  EXPECT_THAT(warnings(), ElementsAre("lines x0 and z1: apart"));
}

TEST_F(SolvedGrid, UnposedReasonNamesTheFirstCause) {
  summary_.features = {{0, 20}, {1, 3000}, {2, 3000}, {31, 3000}};
  summary_.matches = {{2, 40}};
  EXPECT_THAT(unposed_reason(set_, summary_, 0), HasSubstr("only 20 features"));
  EXPECT_THAT(unposed_reason(set_, summary_, 1), HasSubstr("is it a picture of this"));
  EXPECT_THAT(unposed_reason(set_, summary_, 2), HasSubstr("40 matches"));
}

TEST_F(SolvedGrid, CorrectionIsThatOfTheStationsNearestToTheCrossing) {
  for (const int frame : set_.lines[0].frames) {
    result_.poses[frame]->position_m += Eigen::Vector3d(0, 0.003, 0.004);
    result_.poses[frame]->world_from_camera = world_from_camera({0.01, 0, 0});
  }
  for (MeasuredCrossing& crossing : result_.crossings) {
    set_correction(set_, start_, result_.poses, &crossing);
    const bool moved = crossing.check.crossing.along_x == 0;
    EXPECT_NEAR(crossing.correction_mm, moved ? 5.0 : 0.0, 1e-9);
    EXPECT_NEAR(crossing.correction_deg, moved ? degrees_from_radians(0.01) : 0.0, 1e-6);
  }
}

TEST_F(SolvedGrid, DocumentHasTheSolution) {
  result_.position_sigma_mm = 0.0123;
  result_.alignment.spread_m = {1.5, 0.75, 0.0};
  result_.alignment.rank = 2;
  result_.poses[2]->position_m.x() += 0.01;
  result_.poses[4].reset();
  warnings();
  result_.contradictions = {{"off", {2}, "x0_2 lies elsewhere"}};
  result_.times = {{"faces", 1.5, true}, {"features", 41.0, false}};
  result_.unposed = {{4, "too plain"}};
  const nlohmann::json document = this->document();
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
  EXPECT_EQ(document["contradictions"][0]["stations"][0], set_.frames[2].name);
  EXPECT_EQ(document["crossings"][0]["held_out_points"], 500);
  EXPECT_EQ(document["crossings"][0]["position_mm"], 0.0);
  EXPECT_EQ(document["unposed"][0]["reason"], "too plain");
  ASSERT_EQ(document["frames"].size(), 123U);
  const nlohmann::json& moved = document["frames"][2];
  EXPECT_NEAR(moved["position_m"][0].get<double>() - moved["planned_m"][0].get<double>(), 0.01,
              1e-9);
}

// Also for a grid without extent or a solution without poses.
TEST_F(SolvedGrid, DocumentIsWrittenWithNothingSolved) {
  for (CaptureFrame& frame : set_.frames) frame.nominal_m.setZero();
  for (int line = 0; line < 4; ++line) forget(line);
  set_.frames.push_back({.name = "truth", .line = kHeldOut});
  result_.poses.emplace_back();
  result_.keyframes.push_back(124);
  result_.crossings.clear();
  warnings();
  const nlohmann::json document = this->document();
  EXPECT_EQ(document["posed"], 0);
  EXPECT_EQ(document["held_out"]["frames"], 1);
  EXPECT_EQ(document["held_out"]["posed"], 0);
  EXPECT_TRUE(document["frames"].empty());
}

}  // namespace
}  // namespace raywalk::calibrate
