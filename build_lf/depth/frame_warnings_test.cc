#include <gmock/gmock.h>

#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Every warning names the files, the measurement and the consequence.
TEST(FrameWarningsTest, NameFaultFilesAndConsequence) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.width = 32;
  const DepthTestRoom room(spec);
  const FrameChecks checks{
      {{{0, 6}, "x0_006.png", FrameFault::kSameFile, {1, 5}, 0.0625},
       {{0, 9}, "x0_009.png", FrameFault::kNotMoved, {0, 8}, 0.1},
       {{2, 3}, "z0_003.png", FrameFault::kUnlikeNeighbours, {2, 4}, 3.21},
       {{3, 1}, "z1_001.png", FrameFault::kExposureStep, {3, 0}, 1.3}},
      {{0, LineFault::kTooShort, 0.05, 0.125}, {3, LineFault::kTooSparse, 0.75, 0.5}}};
  EXPECT_THAT(warnings_of(room.room(), checks),
              ElementsAre(AllOf(HasSubstr("x0_006.png is a copy of x1_005.png"),
                                HasSubstr("0.062 m"), HasSubstr("not used")),
                          AllOf(HasSubstr("x0_009.png"), HasSubstr("x0_008.png"),
                                HasSubstr("not to have moved"), HasSubstr("not used")),
                          AllOf(HasSubstr("z0_003.png differs from z0_004.png"),
                                HasSubstr("3.2 times"), HasSubstr("not used")),
                          AllOf(HasSubstr("z1_001.png"), HasSubstr("1.30 times that of z1_000.png"),
                                HasSubstr("scaled")),
                          AllOf(HasSubstr("line x0"), HasSubstr("0.050 m"), HasSubstr("0.125 m")),
                          AllOf(HasSubstr("line z1"), HasSubstr("0.750 m"), HasSubstr("0.500 m"))));
  EXPECT_THAT(warnings_of(room.room(), {}), IsEmpty());
}

TEST(ParallaxWarningsTest, NameTheLinesWithoutParallax) {
  const std::vector<MapSummary> maps{
      {.line = "x0", .parallax_share = 0.005}, {.line = "x0", .parallax_share = 0.5},
      {.line = "x1", .parallax_share = 0.9},   {.line = "z0", .parallax_share = 0.0},
      {.line = "z0", .parallax_share = 0.009}, {.line = "z1", .parallax_share = 0.02}};
  EXPECT_THAT(
      parallax_warnings(maps, 81.49),
      ElementsAre(AllOf(HasSubstr("line z0"), HasSubstr("81.5 m"), HasSubstr("did not move"))));
  EXPECT_THAT(parallax_warnings({}, 81.49), IsEmpty());
}

}  // namespace
}  // namespace raywalk::build_lf
