#include "calibrate/grid/estimate_grid.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "calibrate/grid/test_grid.h"
#include "calibrate/grid/test_room.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

GridOptions options_in(const std::filesystem::path& out) {
  return {.method = GridMethod::kRotation, .out = out};
}

// The line along x is rotated by `deg` from where it was planned, and moved by 1 cm per degree.
RoomCapture capture_off_plan(const std::filesystem::path& directory, double deg) {
  return capture_room(directory,
                      {.motion_m = Eigen::Vector3d(0.6, -0.4, 0.7) * 0.01 * deg,
                       .turn_rad = Eigen::Vector3d(0.5, -0.6, 0.62) * radians_from_degrees(deg)});
}

TEST(EstimateGridTest, ALineWithinTheSearchRangeIsAligned) {
  for (const double deg : {0.0, 1.5, 8.0}) {
    const TestDirectory directory;
    const RoomCapture capture = capture_off_plan(directory.path(), deg);
    const GridResult result = estimate_grid(capture.set, {}, options_in(directory / "out"));
    ASSERT_EQ(result.crossings.size(), 1U);
    EXPECT_TRUE(result.trustworthy) << deg << " degrees";
    EXPECT_THAT(result.warnings, IsEmpty()) << deg << " degrees";
    const RelativeError error = relative_error(result.poses, capture.truth, 1, 4);
    EXPECT_LT(error.rotation_deg, 0.15) << deg << " degrees";
    EXPECT_LT(error.position_mm, 8.0) << deg << " degrees";
  }
}

// Matches are searched within kMatchGate_deg. The estimate of a line beyond is wrong, and the
// result has to say so.
TEST(EstimateGridTest, ALineBeyondTheSearchRangeIsReported) {
  const TestDirectory directory;
  const RoomCapture capture = capture_off_plan(directory.path(), kMatchGate_deg + 5.0);
  const GridResult result = estimate_grid(capture.set, {}, options_in(directory / "out"));
  ASSERT_EQ(result.crossings.size(), 1U);
  EXPECT_GT(relative_error(result.poses, capture.truth, 1, 4).rotation_deg, 0.15);
  EXPECT_FALSE(result.trustworthy);
  EXPECT_FALSE(result.crossings[0].trustworthy);
  EXPECT_THAT(result.warnings,
              Contains(AllOf(HasSubstr("lines x0 and z0"), HasSubstr("than the search allows"))));
}

TEST(EstimateGridTest, SolvedPosesOfAnotherPlaceAreReported) {
  const TestDirectory directory;
  const RoomCapture capture = capture_room(directory.path(), {});
  FramePoses solved = capture.truth;
  for (int i = 0; i < 3; ++i) {
    FramePose& pose = *solved[static_cast<size_t>(i)];
    pose.world_from_camera = matrix_of({0.0, 0.03, 0.0}) * pose.world_from_camera;
    pose.position_m.y() += 0.03;
  }
  GridOptions options = options_in(directory / "out");
  options.method = GridMethod::kPoses;
  EXPECT_FALSE(estimate_grid(capture.set, solved, options).trustworthy);
  EXPECT_TRUE(estimate_grid(capture.set, capture.truth, options).trustworthy);
}

TEST(EstimateGridTest, WritesItsReport) {
  const TestDirectory directory;
  const RoomCapture capture = capture_room(directory.path(), {});
  const GridResult result = estimate_grid(capture.set, {}, options_in(directory / "out/deep"));
  const auto written = nlohmann::json::parse(read_file(directory / "out/deep/grid.json"));
  EXPECT_EQ(written["method"], "rotation");
  EXPECT_EQ(written["trustworthy"], result.trustworthy);
  EXPECT_EQ(written["crossings"][0]["held_out_matches"], result.crossings[0].held_out_matches);
}

TEST(EstimateGridTest, AMissingPictureIsNamedAndNothingWritten) {
  const TestDirectory directory;
  const RoomCapture capture = capture_room(directory.path(), {.blank = true});
  std::filesystem::remove(capture.set.frames[2].file);
  try {
    estimate_grid(capture.set, {}, options_in(directory / "out"));
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(capture.set.frames[2].file.string()));
  }
  EXPECT_FALSE(std::filesystem::exists(directory / "out"));
}

}  // namespace
}  // namespace raywalk::calibrate
