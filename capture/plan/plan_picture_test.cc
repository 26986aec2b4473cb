#include "capture/plan/plan_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "capture/plan/test_plan.h"
#include "core/report/markup_check.h"

namespace raywalk::capture {
namespace {

using testing::HasSubstr;
using testing::Not;

std::size_t count_of(std::string_view part, std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos;
       at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

TEST(PlanPicture, ShowsEveryStationLineAndRailEnd) {
  CaptureConfig config = one_cell_config();
  config.validation = {{LineAxis::kZ, 0.1, -0.4, 0.4, 200.0}};
  const CapturePlan plan = plan_capture(config);
  const std::string svg = plan_picture_svg(plan);
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_EQ(count_of("<circle class=\"station\"", svg), 4u * 33u);
  EXPECT_EQ(count_of("<circle class=\"truth\"", svg), 5u);
  EXPECT_EQ(count_of("class=\"start\"", svg), 5u);
  EXPECT_EQ(count_of("<polygon class=\"arrow\"", svg), 5u);
  EXPECT_EQ(count_of("<line class=\"kept-out\"", svg), 1u);
  for (const char* id : {">x0<", ">x1<", ">z0<", ">z1<", ">v0<"}) EXPECT_THAT(svg, HasSubstr(id));
}

// The rail of x0 runs to the right at the back, which is down: bar left of it, arrow right of it.
TEST(PlanPicture, TheRailBeginsAtTheBarAndLeadsToTheArrow) {
  CaptureConfig config = one_cell_config();
  config.grid.overhang_mm = 0.0;
  const std::string svg = plan_picture_svg(plan_capture(config));
  EXPECT_THAT(svg, HasSubstr("class=\"start\" x1=\"46\" y1=\"582\" x2=\"46\" y2=\"570\""));
  EXPECT_THAT(svg, HasSubstr("class=\"arrow\" points=\"592,576 581,571 581,581\""));
}

TEST(PlanPicture, WithoutValidationNothingIsDashed) {
  const std::string svg = plan_picture_svg(plan_capture(one_cell_config()));
  EXPECT_THAT(svg, Not(HasSubstr("class=\"kept-out\"")));
  EXPECT_THAT(svg, Not(HasSubstr("Dashed")));
}

}  // namespace
}  // namespace raywalk::capture
