#include "capture/session/plan_difference.h"

#include <gmock/gmock.h>

#include "capture/session/test_session.h"

namespace raywalk::capture {
namespace {

using testing::HasSubstr;

TEST(PlanDifferenceTest, OfAPlanAndItselfIsNone) {
  EXPECT_EQ(plan_difference(test_plan(true), test_plan(true)), "");
}

TEST(PlanDifferenceTest, OfRoundingIsNone) {
  CapturePlan here = test_plan();
  here.lines[0].stations[0].position_m.x_m += 1e-9;
  here.lines[0].stations[0].rail_mm += 1e-6;
  EXPECT_EQ(plan_difference(test_plan(), here), "");
}

TEST(PlanDifferenceTest, CountsStations) {
  CapturePlan here = test_plan();
  here.lines[1].stations.pop_back();
  EXPECT_EQ(plan_difference(test_plan(), here), "line x1 has 3 stations there, 2 here");
}

TEST(PlanDifferenceTest, CountsLines) {
  EXPECT_EQ(plan_difference(test_plan(true), test_plan()), "it has 5 lines there, 4 here");
}

TEST(PlanDifferenceTest, NamesTheFirstStationThatLiesElsewhere) {
  CapturePlan here = test_plan();
  here.lines[2].stations[1].position_m.z_m += 0.01;
  here.lines[3].stations[0].position_m.z_m += 0.01;
  EXPECT_EQ(plan_difference(test_plan(), here),
            "station z0_001 lies at x = -0.5, z = 0 m there, x = -0.5, z = 0.01 m here");
}

TEST(PlanDifferenceTest, FindsAnotherPositionOnTheRail) {
  CapturePlan here = test_plan();
  here.lines[0].stations[1].rail_mm = 810.0;
  EXPECT_EQ(plan_difference(test_plan(), here),
            "station x0_001 lies at 800 mm on the rail there, 810 mm here");
}

TEST(PlanDifferenceTest, FindsALineThatBecameValidation) {
  CapturePlan here = test_plan();
  here.lines[0].validation = true;
  EXPECT_EQ(plan_difference(test_plan(), here),
            "line x0 is along x there, for validation along x here");
}

}  // namespace
}  // namespace raywalk::capture
