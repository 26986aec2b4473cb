#include "core/report/plan_drawing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/report/markup_check.h"

namespace raywalk {
namespace {

using testing::HasSubstr;
using testing::Not;

PlanBounds bounds_of(PlanPoint a, PlanPoint b) {
  PlanBounds bounds;
  bounds.add(a);
  bounds.add(b);
  return bounds;
}

TEST(PlanDrawing, TheFrontIsUpAndTheLongerSideIs520Pixels) {
  PlanDrawing drawing(bounds_of({-1.0, -0.5}, {1.0, 0.5}), 40.0);
  drawing.add_dot("mark", {-1.0, 0.5}, 2.0);
  drawing.add_line("rail", {-1.0, -0.5}, {1.0, -0.5});
  const std::vector<PlanPoint> corners{{0.0, 0.0}, {1.0, 0.0}, {0.0, 0.5}};
  drawing.add_polygon("cell", corners);
  const std::string svg = drawing.svg("A plan", "");
  EXPECT_THAT(svg, HasSubstr("<circle class=\"mark\" cx=\"40\" cy=\"40\" r=\"2\"/>"));
  EXPECT_THAT(svg, HasSubstr("<line class=\"rail\" x1=\"40\" y1=\"300\" x2=\"560\" y2=\"300\"/>"));
  EXPECT_THAT(svg, HasSubstr("<polygon class=\"cell\" points=\"300,170 560,170 300,40\"/>"));
  EXPECT_THAT(svg, HasSubstr("width=\"600\" height=\"362\""));
  EXPECT_DOUBLE_EQ(drawing.metres_of(260.0), 1.0);
}

TEST(PlanDrawing, TheScaleBarIsARoundLengthOfAboutAQuarter) {
  const auto svg = [](double side_m) {
    return PlanDrawing(bounds_of({0.0, 0.0}, {side_m, side_m}), 20.0).svg("", "");
  };
  EXPECT_THAT(svg(1.0), HasSubstr(">0.2 m; front"));
  EXPECT_THAT(svg(2.0), HasSubstr(">0.5 m; front"));
  EXPECT_THAT(svg(9.0), HasSubstr(">2 m; front"));
  EXPECT_THAT(svg(2.0), HasSubstr("class=\"scale\" x1=\"20\" y1=\"570\" x2=\"150\""));
}

TEST(PlanDrawing, TextIsEscapedAndMarkupIsWellFormed) {
  PlanDrawing drawing(bounds_of({0.0, 0.0}, {1.0, 1.0}), 20.0);
  for (const LabelSide side :
       {LabelSide::kLeft, LabelSide::kRight, LabelSide::kAbove, LabelSide::kBelow}) {
    drawing.add_label("<x0>", {0.0, 1.0}, side);
  }
  const std::vector<std::string> notes{"a & b", "c"};
  const std::string svg =
      drawing.svg("A <plan>", ".raywalk-plan .a { fill: var(--ink); }\n", notes);
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_THAT(svg, Not(HasSubstr("<x0>")));
  EXPECT_THAT(svg, HasSubstr("x=\"14\" y=\"25\" text-anchor=\"end\">&lt;x0&gt;<"));
  EXPECT_THAT(svg, HasSubstr("x=\"26\" y=\"25\" text-anchor=\"start\">"));
  EXPECT_THAT(svg, HasSubstr("x=\"20\" y=\"14\" text-anchor=\"middle\">"));
  EXPECT_THAT(svg, HasSubstr("x=\"20\" y=\"36\" text-anchor=\"middle\">"));
  EXPECT_THAT(svg, HasSubstr("a &amp; b"));
}

}  // namespace
}  // namespace raywalk
