#include <gmock/gmock.h>

#include "calibrate/grid/estimate_grid.h"
#include "calibrate/grid/test_grid.h"
#include "core/base/error.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::Gt;
using testing::HasSubstr;
using testing::Lt;

GridResult estimate(const TestGrid& grid, GridMethod method = GridMethod::kPoses) {
  return estimate_from_matches(grid.set, method, grid.solved, nominal_poses(grid.set),
                               grid.crossings);
}

RelativeError error_at(const TestGrid& grid, const GridResult& result, size_t crossing) {
  return relative_error(result.poses, grid.truth, grid.crossings[crossing].frames_x.front(),
                        grid.crossings[crossing].frames_z.front());
}

std::string all_of(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + "\n";
  return all;
}

// Settings for a fast test.
TestGridSettings small_grid() {
  TestGridSettings settings;
  settings.stations = 21;
  settings.matches = 40;
  return settings;
}

TEST(GridEstimationTest, CrossingsAgreeAsFarAsSolvedPosesAllow) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const TestGrid grid = TestGridMaker(small_grid(), seed).make();
    const GridResult result = estimate(grid);
    EXPECT_TRUE(result.trustworthy) << all_of(result.warnings);
    ASSERT_EQ(result.crossings.size(), 4U);
    for (size_t i = 0; i < 4; ++i) {
      // 0.1 mm and 0.005 degrees per component and pose.
      EXPECT_LT(error_at(grid, result, i).position_mm, 0.7);
      EXPECT_LT(error_at(grid, result, i).rotation_deg, 0.035);
    }
    EXPECT_NEAR(result.scale, 1.0, 1e-3);
  }
}

TEST(GridEstimationTest, WrongPosesAreRejectedAndNamed) {
  TestGrid grid = TestGridMaker(small_grid(), 5).make();
  std::vector<int> wrong;
  for (const CaptureLine& line : grid.set.lines) {
    for (const size_t station : {0U, 10U}) {  // away from the crossings
      wrong.push_back(line.frames[station]);
      grid.solved[static_cast<size_t>(wrong.back())]->position_m +=
          Eigen::Vector3d(0.03, -0.03, 0.03);
    }
  }
  const GridResult result = estimate(grid);
  std::vector<int> rejected;
  for (const LineFit& line : result.lines) {
    rejected.insert(rejected.end(), line.rejected_frames.begin(), line.rejected_frames.end());
  }
  EXPECT_EQ(rejected, wrong);
  EXPECT_THAT(all_of(result.notes), HasSubstr("x0_000, x0_010"));
  for (const int frame : wrong) {
    const FramePose& pose = *result.poses[static_cast<size_t>(frame)];
    EXPECT_EQ(pose.origin, PoseOrigin::kRail);
    // The rail predicts it within the stations' scatter, 1 mm per component.
    EXPECT_LT(relative_error(result.poses, grid.truth, frame, frame + 1).position_mm, 5.0);
  }
  ASSERT_EQ(result.crossings.size(), 4U);
  for (size_t i = 0; i < result.crossings.size(); ++i) {
    EXPECT_LT(error_at(grid, result, i).position_mm, 0.7);
  }
}

// Errors over their sigmas squared have the mean 1, over many draws.
TEST(GridEstimationTest, SigmasOfCrossingsAreHonest) {
  TestGridSettings settings = small_grid();
  settings.stations = 13;
  settings.matches = 8;
  double position = 0.0, rotation = 0.0;
  int count = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    const TestGrid grid = TestGridMaker(settings, 100 + seed).make();
    const GridResult result = estimate(grid);
    for (size_t i = 0; i < result.crossings.size(); ++i) {
      const RelativeError error = error_at(grid, result, i);
      position += std::pow(error.position_mm / result.crossings[i].sigma_mm, 2) / 3.0;
      rotation += std::pow(error.rotation_deg / result.crossings[i].sigma_deg, 2) / 3.0;
      ++count;
    }
  }
  // Of 120 crossings with three components each, the mean is within 0.8 and 1.2 with a probability
  // of 0.99.
  EXPECT_THAT(position / count, AllOf(Gt(0.75), Lt(1.25)));
  EXPECT_THAT(rotation / count, AllOf(Gt(0.75), Lt(1.25)));
}

TEST(GridEstimationTest, SigmasOfLinesAreHonest) {
  TestGridSettings settings = small_grid();
  settings.lines_z = 1;
  settings.lines_x = 3;
  settings.matches = 3;
  double heading = 0.0;
  int count = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    const TestGrid grid = TestGridMaker(settings, 300 + seed).make();
    const GridResult result = estimate(grid);
    // Relative to another line, as the common motion is unobservable.
    const auto difference = [&](size_t a, size_t b) {
      return degrees_from_radians(grid.rails[a][RailParameter::kHeading] -
                                  grid.rails[b][RailParameter::kHeading]);
    };
    const LineFit& one = result.lines[0];
    const LineFit& two = result.lines[2];
    const double error = one.heading_deg.value - two.heading_deg.value - difference(0, 2);
    heading +=
        error * error / (std::pow(one.heading_deg.sigma, 2) + std::pow(two.heading_deg.sigma, 2));
    ++count;
  }
  // The mean square of 30 normal numbers is within 0.5 and 1.75 with a probability of 0.99. It is a
  // little smaller here, as each line's sigma is relative to the mean of all.
  EXPECT_THAT(heading / count, AllOf(Gt(0.45), Lt(1.8)));
}

TEST(GridEstimationTest, SkippedStationsArePredictedToTheirScatter) {
  TestGrid grid = TestGridMaker(TestGridSettings{}, 8).make();
  double square = 0.0, sigma_square = 0.0, turn_square = 0.0, turn_sigma_square = 0.0;
  int count = 0;
  for (size_t i = 0; i < grid.solved.size(); ++i) {
    if (i % 3 != 0) grid.solved[i].reset();
  }
  const GridResult result = estimate(grid);
  for (size_t i = 1; i + 1 < grid.solved.size(); ++i) {
    if (grid.solved[i] || !grid.solved[i - 1]) continue;
    // Relative to its solved neighbour, which is known well.
    const RelativeError error =
        relative_error(result.poses, grid.truth, static_cast<int>(i) - 1, static_cast<int>(i));
    EXPECT_EQ(result.poses[i]->origin, PoseOrigin::kRail);
    square += error.position_mm * error.position_mm / 3.0;
    sigma_square += std::pow(result.poses[i]->position_sigma_mm, 2);
    turn_square += error.rotation_deg * error.rotation_deg / 3.0;
    turn_sigma_square += std::pow(result.poses[i]->rotation_sigma_deg, 2);
    ++count;
  }
  ASSERT_GT(count, 40);
  EXPECT_NEAR(std::sqrt(sigma_square / count), 1.0, 0.3);  // what the rails were made with
  EXPECT_NEAR(std::sqrt(square / sigma_square), 1.0, 0.25);
  EXPECT_NEAR(std::sqrt(turn_square / turn_sigma_square), 1.0, 0.25);
  EXPECT_TRUE(result.trustworthy) << all_of(result.warnings);
}

TEST(GridEstimationTest, FrameAndScaleOfSolvedPosesDoNotMatter) {
  const TestGrid grid = TestGridMaker(small_grid(), 9).make();
  TestGrid moved = grid;
  const Eigen::Matrix3d turn = matrix_of({0.4, -1.1, 0.7});
  for (std::optional<FramePose>& pose : moved.solved) {
    pose->position_m = 3.7 * (turn * pose->position_m) + Eigen::Vector3d(5, -2, 11);
    pose->position_sigma_mm *= 3.7;
    pose->world_from_camera = turn * pose->world_from_camera;
  }
  const GridResult one = estimate(grid);
  const GridResult two = estimate(moved);
  EXPECT_NEAR(two.scale * 3.7, one.scale, 1e-6);
  for (size_t i = 0; i < grid.solved.size(); ++i) {
    EXPECT_LT((one.poses[i]->position_m - two.poses[i]->position_m).norm(), 1e-6);
    EXPECT_LT(angle_between(one.poses[i]->world_from_camera, two.poses[i]->world_from_camera),
              1e-6);
  }
}

TEST(GridEstimationTest, TheMeanPositionIsThatOfThePlan) {
  const TestGrid grid = TestGridMaker(small_grid(), 10).make();
  const GridResult result = estimate(grid);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < grid.set.frames.size(); ++i) {
    mean += result.poses[i]->position_m - grid.set.frames[i].nominal_m;
  }
  EXPECT_LT((mean / static_cast<double>(grid.set.frames.size())).norm(), 2e-4);
}

TEST(GridEstimationTest, BowAndTwistAreFoundWhereTheyAre) {
  TestGridSettings settings;
  settings.bow_mm = 3.0;
  settings.twist_deg = 0.5;
  const TestGrid grid = TestGridMaker(settings, 11).make();
  const GridResult result = estimate(grid);
  ASSERT_EQ(result.lines.size(), 4U);
  for (const LineFit& line : result.lines) {
    EXPECT_NEAR(line.bow_mm[0].x(), 3.0, 1.5) << line.id;
    const Eigen::Index about =
        grid.set.lines[static_cast<size_t>(line.line)].axis == LineAxis::kX ? 0 : 2;
    EXPECT_NEAR(line.twist_deg[0][about], 0.5, 0.12) << line.id;
  }
}

TEST(GridEstimationTest, RotationMethodAlignsLinesWithoutAnyPose) {
  for (const unsigned seed : {21U, 22U, 23U}) {
    TestGrid grid = TestGridMaker(small_grid(), seed).make();
    for (auto& pose : grid.solved) pose.reset();
    const GridResult result = estimate(grid, GridMethod::kRotation);
    EXPECT_TRUE(result.trustworthy) << all_of(result.warnings);
    ASSERT_EQ(result.crossings.size(), 4U);
    for (size_t i = 0; i < result.crossings.size(); ++i) {
      const CrossingFigures& crossing = result.crossings[i];
      EXPECT_GT(crossing.before.rotation_deg, 10.0 * crossing.after.rotation_deg);
      const RelativeError error = error_at(grid, result, i);
      EXPECT_LT(error.rotation_deg, 5.0 * crossing.sigma_deg);
      EXPECT_LT(error.rotation_deg, 0.15);
      EXPECT_LT(error.position_mm, 5.0 * crossing.sigma_mm);
    }
  }
}

TEST(GridEstimationTest, ALineWithLargeCommonErrorIsReported) {
  for (const bool turned : {false, true}) {
    TestGrid grid = TestGridMaker(small_grid(), 31).make();
    for (const int frame : grid.set.lines[2].frames) {
      FramePose& pose = *grid.solved[static_cast<size_t>(frame)];
      if (turned) {
        pose.world_from_camera = matrix_of({0.0, 0.02, 0.0}) * pose.world_from_camera;
      } else {
        pose.position_m += Eigen::Vector3d(0.0, 0.06, 0.0);
      }
    }
    const GridResult result = estimate(grid);
    EXPECT_FALSE(result.trustworthy);
    EXPECT_THAT(all_of(result.warnings), HasSubstr("solved poses of whole lines are off"));
  }
}

// Common errors of lines are not in the sigmas of bundle adjustment, but crossings show them.
TEST(GridEstimationTest, SmallCommonErrorsOfLinesAreCorrected) {
  double before = 0.0;
  double after = 0.0;
  for (const unsigned seed : {61U, 62U, 63U}) {
    TestGridSettings settings{
        .stations = 21, .solved_mm = 0.05, .solved_deg = 0.002, .matches = 100, .noise_deg = 0.02};
    TestGridMaker maker(settings, seed);
    TestGrid grid = maker.make();
    for (const CaptureLine& line : grid.set.lines) {
      const Eigen::Vector3d off = maker.normal3(1e-3);
      for (const int frame : line.frames)
        grid.solved[static_cast<size_t>(frame)]->position_m += off;
    }
    const GridResult result = estimate(grid);
    EXPECT_TRUE(result.trustworthy) << all_of(result.warnings);
    EXPECT_NEAR(result.solved_line_error_mm, 1.0, 0.6);
    EXPECT_LT(result.solved_line_error_deg, 0.02);
    ASSERT_EQ(result.crossings.size(), 4U);
    for (size_t i = 0; i < result.crossings.size(); ++i) {
      const CrossingMatches& crossing = grid.crossings[i];
      before += relative_error(grid.solved, grid.truth, crossing.frames_x.front(),
                               crossing.frames_z.front())
                    .position_mm;
      after += error_at(grid, result, i).position_mm;
      EXPECT_LT(error_at(grid, result, i).position_mm,
                4.0 * std::sqrt(3.0) * result.crossings[i].sigma_mm);
    }
  }
  EXPECT_LT(after, 0.4 * before);
}

TEST(GridEstimationTest, AnUnconnectedLineIsReportedAndNotMoved) {
  TestGrid grid = TestGridMaker(small_grid(), 33).make();
  for (CrossingMatches& crossing : grid.crossings) {
    if (crossing.crossing.along_z == 3) crossing.matches.clear();
  }
  const GridResult result = estimate(grid, GridMethod::kRotation);
  EXPECT_FALSE(result.trustworthy);
  EXPECT_THAT(result.warnings, Contains(HasSubstr("line z1: not connected")));
  EXPECT_FALSE(result.lines[3].connected);
  EXPECT_TRUE(result.lines[0].connected);
  for (const int frame : grid.set.lines[3].frames) {
    EXPECT_LT((result.poses[static_cast<size_t>(frame)]->position_m -
               grid.set.frames[static_cast<size_t>(frame)].nominal_m)
                  .norm(),
              1e-6);
  }
}

TEST(GridEstimationTest, AnUnsolvedLineIsPositionedByItsCrossings) {
  TestGrid grid = TestGridMaker(small_grid(), 34).make();
  for (const int frame : grid.set.lines[0].frames) grid.solved[static_cast<size_t>(frame)].reset();
  const GridResult result = estimate(grid);
  ASSERT_EQ(result.crossings.size(), 4U);
  for (size_t i = 0; i < result.crossings.size(); ++i) {
    EXPECT_LT(error_at(grid, result, i).rotation_deg, 0.15);
    EXPECT_LT(error_at(grid, result, i).position_mm, 6.0);
  }
}

TEST(GridEstimationTest, MatchesOfAnotherRoomAreReported) {
  TestGridSettings settings = small_grid();
  settings.wrong_share = 1.0;
  settings.matches = 15;
  const TestGrid grid = TestGridMaker(settings, 35).make();
  for (const GridMethod method : {GridMethod::kPoses, GridMethod::kRotation}) {
    const GridResult result = estimate(grid, method);
    EXPECT_FALSE(result.trustworthy);
    ASSERT_EQ(result.crossings.size(), 4U);
    for (const CrossingFigures& crossing : result.crossings) {
      EXPECT_FALSE(crossing.trustworthy);
    }
  }
}

TEST(GridEstimationTest, OneLineIsStraightenedAndNoted) {
  TestGridSettings settings = small_grid();
  settings.lines_z = 0;
  settings.lines_x = 1;
  const TestGrid grid = TestGridMaker(settings, 41).make();
  const GridResult result = estimate(grid);
  EXPECT_TRUE(result.trustworthy) << all_of(result.warnings);
  EXPECT_THAT(result.notes, Contains(HasSubstr("one line only")));
  for (int i = 1; i < settings.stations; ++i) {
    // The slider's feedback gives the scale to 0.1 % despite the stations' scatter.
    EXPECT_LT(relative_error(result.poses, grid.truth, 0, i).position_mm, 2.0);
  }
  EXPECT_THROW(estimate(grid, GridMethod::kRotation), Error);
}

TEST(GridEstimationTest, NothingSolvedIsAnError) {
  TestGrid grid = TestGridMaker(small_grid(), 42).make();
  for (auto& pose : grid.solved) pose.reset();
  try {
    estimate(grid);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("--method rotation"));
  }
}

// Grids of any size, with or without noise, give similar results without non-finite figures.
TEST(GridEstimationTest, ExtremesStayFinite) {
  for (const double cell_m : {1e-3, 1.0, 1e3}) {
    for (const bool exact : {false, true}) {
      for (const int lines : {1, 2}) {
        TestGridSettings settings = small_grid();
        settings.stations = 9;
        settings.matches = 20;
        settings.lines_x = lines;
        settings.cell_m = cell_m;
        settings.placing_mm *= cell_m;
        settings.jitter_mm *= exact ? 0.0 : cell_m;
        settings.solved_mm *= exact ? 0.0 : cell_m;
        if (exact) {
          settings.jitter_deg = settings.solved_deg = settings.noise_deg = settings.wrong_share = 0;
        }
        const TestGrid grid = TestGridMaker(settings, 50).make();
        for (const GridMethod method : {GridMethod::kPoses, GridMethod::kRotation}) {
          const GridResult result = estimate(grid, method);
          ASSERT_EQ(result.crossings.size(), 2U * static_cast<size_t>(lines));
          ASSERT_EQ(result.lines.size(), 2U + static_cast<size_t>(lines));
          ASSERT_EQ(result.poses.size(), grid.set.frames.size());
          for (size_t i = 0; i < result.crossings.size(); ++i) {
            const CrossingFigures& crossing = result.crossings[i];
            EXPECT_THAT((std::vector<double>{
                            crossing.sigma_mm, crossing.sigma_deg, crossing.after.position_mm,
                            crossing.after.position_sigma_mm, crossing.after.rotation_deg,
                            crossing.after.rotation_sigma_deg, crossing.split_half_expected_mm}),
                        Each(AllOf(testing::Ge(0.0), Lt(1e4 * cell_m + 10.0))));
            if (method == GridMethod::kPoses) {
              EXPECT_LT(error_at(grid, result, i).position_mm, exact ? 1e-2 * cell_m : cell_m);
            }
          }
          for (const std::optional<FramePose>& pose : result.poses) {
            ASSERT_TRUE(pose);
            EXPECT_TRUE(pose->position_m.allFinite());
            EXPECT_TRUE(std::isfinite(pose->position_sigma_mm));
            EXPECT_TRUE(std::isfinite(pose->rotation_sigma_deg));
          }
          for (const LineFit& line : result.lines) EXPECT_TRUE(line.covariance.allFinite());
        }
      }
    }
  }
}

}  // namespace
}  // namespace raywalk::calibrate
