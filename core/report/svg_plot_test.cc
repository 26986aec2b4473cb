#include "core/report/svg_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>
#include <string>
#include <vector>

#include "core/report/markup_check.h"
#include "core/report/text_box.h"

namespace raywalk {
namespace {

using testing::HasSubstr;
using testing::Not;

LinePlot simple_plot() {
  return {.title = "Growth",
          .x_label = "time (s)",
          .y_label = "length (m)",
          .series = {{.name = "measured", .points = {{0.0, 0.0}, {5.0, 1.0}, {10.0, 2.0}}}}};
}

// The pixels of each series' polylines.
std::vector<std::vector<PlotPoint>> polylines(const std::string& svg) {
  std::vector<std::vector<PlotPoint>> lines;
  const std::regex polyline("<polyline[^>]*points=\"([^\"]*)\"");
  const std::regex pair("([-0-9.]+),([-0-9.]+)");
  for (std::sregex_iterator i(svg.begin(), svg.end(), polyline), end; i != end; ++i) {
    const std::string points = (*i)[1];
    std::vector<PlotPoint>& line = lines.emplace_back();
    for (std::sregex_iterator j(points.begin(), points.end(), pair); j != end; ++j) {
      line.push_back({std::stod((*j)[1]), std::stod((*j)[2])});
    }
  }
  return lines;
}

// Where the label of an axis tick is printed.
PlotPoint tick_label(const std::string& svg, const std::string& anchor, const std::string& label) {
  const std::regex text("<text x=\"([-0-9.]+)\" y=\"([-0-9.]+)\" class=\"tick\" text-anchor=\"" +
                        anchor + "\">" + label + "<");
  std::smatch match;
  if (!std::regex_search(svg, match, text)) return {std::nan(""), std::nan("")};
  return {std::stod(match[1]), std::stod(match[2])};
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

TEST(SvgPlot, IsWellFormed) { EXPECT_EQ(markup_fault(svg_from_plot(simple_plot())), ""); }

TEST(SvgPlot, PointsLieAtTheTicksOfTheirCoordinates) {
  const std::string svg = svg_from_plot(simple_plot());
  const auto lines = polylines(svg);
  ASSERT_EQ(lines.size(), 1U);
  ASSERT_EQ(lines[0].size(), 3U);
  EXPECT_NEAR(lines[0][0].x, tick_label(svg, "middle", "0").x, 0.02);
  EXPECT_NEAR(lines[0][1].x, tick_label(svg, "middle", "5").x, 0.02);
  EXPECT_NEAR(lines[0][2].x, tick_label(svg, "middle", "10").x, 0.02);
  // A label's baseline is 4 px below its tick.
  EXPECT_NEAR(lines[0][0].y, tick_label(svg, "end", "0.0").y - 4.0, 0.02);
  EXPECT_NEAR(lines[0][1].y, tick_label(svg, "end", "1.0").y - 4.0, 0.02);
  EXPECT_NEAR(lines[0][2].y, tick_label(svg, "end", "2.0").y - 4.0, 0.02);
  EXPECT_LT(lines[0][2].y, lines[0][0].y);  // y grows upwards
}

TEST(SvgPlot, StaysWithinThePicture) {
  LinePlot plot = simple_plot();
  plot.width_px = 300;
  plot.height_px = 200;
  for (const auto& line : polylines(svg_from_plot(plot))) {
    for (const PlotPoint& point : line) {
      EXPECT_THAT(point.x, testing::AllOf(testing::Ge(0.0), testing::Le(300.0)));
      EXPECT_THAT(point.y, testing::AllOf(testing::Ge(0.0), testing::Le(200.0)));
    }
  }
}

// What is left of a phone's 360 px within margins and a card.
TEST(SvgPlot, FitsAPhoneWithTextsThatCanBeRead) {
  constexpr double kPhone_px = 300.0;
  const std::string svg = svg_from_plot(simple_plot());
  std::smatch least, width, font;
  ASSERT_TRUE(std::regex_search(svg, least, std::regex("min-width: ([0-9.]+)px")));
  EXPECT_LE(std::stod(least[1]), kPhone_px);
  ASSERT_TRUE(std::regex_search(svg, width, std::regex("viewBox=\"0 0 ([0-9]+) ")));
  ASSERT_TRUE(std::regex_search(svg, font, std::regex("text \\{ font: ([0-9]+)px")));
  EXPECT_GE(std::stod(font[1]) * kPhone_px / std::stod(width[1]), 8.0);
}

// Where the labels of points and references are printed.
std::vector<PlotPoint> notes(const std::string& svg) {
  const std::regex note("<text x=\"([-0-9.]+)\" y=\"([-0-9.]+)\" class=\"note\"");
  std::vector<PlotPoint> found;
  for (std::sregex_iterator i(svg.begin(), svg.end(), note), end; i != end; ++i) {
    found.push_back({std::stod((*i)[1]), std::stod((*i)[2])});
  }
  return found;
}

TEST(SvgPlot, NamesEverything) {
  LinePlot plot = simple_plot();
  plot.references = {{5.0, "half time"}};
  const std::string svg = svg_from_plot(plot);
  for (const char* text : {"Growth", "time (s)", "length (m)", "measured", "half time"}) {
    EXPECT_THAT(svg, HasSubstr(std::string(">") + text + "</text>"));
  }
}

TEST(SvgPlot, EscapesEveryText) {
  LinePlot plot = simple_plot();
  plot.title = plot.x_label = plot.y_label = plot.series[0].name = "<script>&";
  plot.references = {{5.0, "<script>&"}};
  const std::string svg = svg_from_plot(plot);
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_THAT(svg, Not(HasSubstr("<script>")));
  EXPECT_EQ(count(svg, "&lt;script&gt;&amp;"), 6U);  // and once as the picture's name
}

TEST(SvgPlot, ReferenceStandsAtItsValue) {
  LinePlot plot = simple_plot();
  plot.references = {{5.0, "middle"}, {11.0, "outside"}};
  const std::string svg = svg_from_plot(plot);
  std::smatch match;
  ASSERT_TRUE(std::regex_search(svg, match, std::regex("class=\"reference\" x1=\"([-0-9.]+)\"")));
  EXPECT_NEAR(std::stod(match[1]), tick_label(svg, "middle", "5").x, 0.02);
  EXPECT_THAT(svg, Not(HasSubstr("outside")));
}

TEST(SvgPlot, LabelsOfNeighbouringReferencesPointAwayFromEachOther) {
  LinePlot plot = simple_plot();
  plot.references = {{6.0, "right one"}, {5.8, "left one"}};
  const std::string svg = svg_from_plot(plot);
  EXPECT_THAT(svg, HasSubstr("text-anchor=\"end\">left one<"));
  EXPECT_THAT(svg, HasSubstr("text-anchor=\"start\">right one<"));
  plot.references = {{10.0, "at the right edge"}};
  EXPECT_THAT(svg_from_plot(plot), HasSubstr("text-anchor=\"end\">at the right edge<"));
  plot.references = {{0.0, "at the left edge"}, {10.0, "last"}};
  EXPECT_THAT(svg_from_plot(plot), HasSubstr("text-anchor=\"start\">at the left edge<"));
}

TEST(SvgPlot, LabelsOfReferencesLieAboveTheData) {
  LinePlot plot = simple_plot();
  plot.references = {{0.0, "LFU"}, {5.8, "left one"}, {6.0, "right one"}};
  const std::string svg = svg_from_plot(plot);
  const std::regex axis("class=\"axis\" d=\"M[-0-9.]+ ([-0-9.]+)V");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(svg, match, axis));
  const double top = std::stod(match[1]);
  const std::vector<PlotPoint> labels = notes(svg);
  ASSERT_EQ(labels.size(), 3U);
  for (const PlotPoint& label : labels) EXPECT_LT(label.y, top);
}

TEST(SvgPlot, LeavesAGapWhereAPointIsNotFinite) {
  LinePlot plot = simple_plot();
  plot.series[0].points = {{0.0, 0.0},
                           {1.0, 1.0},
                           {2.0, std::nan("")},
                           {3.0, std::numeric_limits<double>::infinity()},
                           {4.0, 2.0}};
  const std::string svg = svg_from_plot(plot);
  const auto lines = polylines(svg);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].size(), 2U);
  EXPECT_EQ(lines[1].size(), 1U);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(SvgPlot, DrawsLogarithmicAxesAndLeavesAGapWhereAValueIsNotPositive) {
  LinePlot plot = simple_plot();
  plot.x_scale = plot.y_scale = AxisScale::kLogarithmic;
  plot.series[0].points = {{1e-2, 1e-8}, {1.0, 1e-4}, {2.0, 0.0}, {10.0, 1e-3}, {100.0, 1.0}};
  plot.references = {{-1.0, "nowhere"}};
  const std::string svg = svg_from_plot(plot);
  const auto lines = polylines(svg);
  ASSERT_EQ(lines.size(), 2U);
  ASSERT_EQ(lines[0].size(), 2U);
  EXPECT_NEAR(lines[0][0].x, tick_label(svg, "middle", "1e-2").x, 0.02);
  EXPECT_NEAR(lines[0][1].x, tick_label(svg, "middle", "1").x, 0.02);
  EXPECT_NEAR(lines[0][0].y, tick_label(svg, "end", "1e-8").y - 4.0, 0.02);
  EXPECT_NEAR(lines[0][1].y, tick_label(svg, "end", "1e-4").y - 4.0, 0.02);
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_THAT(svg, Not(HasSubstr("nowhere")));
}

TEST(SvgPlot, DrawsPointsLinesOrBoth) {
  LinePlot plot = simple_plot();
  plot.series[0].style = PlotStyle::kPoints;
  const std::string points = svg_from_plot(plot);
  EXPECT_EQ(count(points, "<polyline"), 0U);
  EXPECT_EQ(count(points, "<circle"), 3U + 1U);  // one in the legend
  plot.series[0].style = PlotStyle::kLineAndPoints;
  const std::string both = svg_from_plot(plot);
  EXPECT_EQ(count(both, "<polyline"), 1U);
  EXPECT_EQ(count(both, "<circle"), 3U + 1U);
}

TEST(SvgPlot, GivesSeriesDifferentColours) {
  LinePlot plot = simple_plot();
  plot.series.push_back({.name = "expected", .points = {{0.0, 1.0}, {10.0, 1.0}}});
  const std::string svg = svg_from_plot(plot);
  EXPECT_THAT(svg, HasSubstr("<polyline class=\"line c0\""));
  EXPECT_THAT(svg, HasSubstr("<polyline class=\"line c1\""));
}

TEST(SvgPlot, WrapsALongLegendAndKeepsThePlotBelowIt) {
  LinePlot plot = simple_plot();
  const double top_before = polylines(svg_from_plot(plot))[0][2].y;
  for (int i = 0; i < 12; ++i) {
    plot.series.push_back({.name = "a series with a long name " + std::to_string(i), .points = {}});
  }
  EXPECT_GT(polylines(svg_from_plot(plot))[0][2].y, top_before + 50.0);
}

TEST(SvgPlot, HonoursAGivenRange) {
  LinePlot plot = simple_plot();
  plot.y_range = AxisRange{0.0, 4.0};
  const std::string svg = svg_from_plot(plot);
  EXPECT_NEAR(polylines(svg)[0][2].y, tick_label(svg, "end", "2.0").y - 4.0, 0.02);
  EXPECT_FALSE(std::isnan(tick_label(svg, "end", "4.0").y));
}

TEST(SvgPlot, LogarithmicPointsLieAtTheirTicksToo) {
  LinePlot plot = simple_plot();
  plot.x_scale = AxisScale::kLogarithmic;
  plot.series[0].points = {{-1.0, 1.0}, {0.0, 1.0}, {1.0, 0.0}, {10.0, 1.0}, {100.0, 2.0}};
  plot.x_range = AxisRange{1.0, 100.0};
  const std::string svg = svg_from_plot(plot);
  ASSERT_EQ(polylines(svg).size(), 1U);  // what is not positive has no place
  ASSERT_EQ(polylines(svg)[0].size(), 3U);
  EXPECT_NEAR(polylines(svg)[0][1].x, tick_label(svg, "middle", "10").x, 0.02);
  EXPECT_EQ(markup_fault(svg), "");
}

TEST(SvgPlot, PointsHaveLinksAndTitles) {
  LinePlot plot = simple_plot();
  plot.series[0].style = PlotStyle::kRings;
  plot.series[0].marks = {{.link = "#a&b", .title = "first <one>", .label = "no. 1"}, {}, {}};
  const std::string svg = svg_from_plot(plot);
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_THAT(svg, HasSubstr("<a href=\"#a&amp;b\">\n<title>first &lt;one&gt;</title>\n<circle "
                             "class=\"ring c0\""));
  EXPECT_EQ(count(svg, "<a href"), 1U);
  EXPECT_EQ(count(svg, ">no. 1<"), 1U);
  EXPECT_TRUE(polylines(svg).empty());
}

TEST(SvgPlot, LabelsOfPointsDoNotOverlap) {
  LinePlot plot = simple_plot();
  plot.series[0].points = std::vector<PlotPoint>(9, {5.0, 1.0});
  for (char name = 'a'; name <= 'i'; ++name) {
    plot.series[0].marks.push_back({.label = std::string(20, name)});
  }
  const std::vector<PlotPoint> labels = notes(svg_from_plot(plot));
  plot.series[0].style = PlotStyle::kPoints;
  const std::vector<PlotPoint> places = notes(svg_from_plot(plot));
  EXPECT_TRUE(labels.empty());   // a line has no points to label
  ASSERT_GE(places.size(), 4U);  // in the four corners at least
  EXPECT_LT(places.size(), 9U);  // the last at one place has no room
  const double width = text_px(std::string(20, 'a'));
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_TRUE(std::abs(places[i].x - places[j].x) >= width ||
                  std::abs(places[i].y - places[j].y) >= kFontPx);
    }
  }
}

TEST(SvgPlot, ASeriesMayStayOutOfTheLegendAndChooseItsColour) {
  LinePlot plot = simple_plot();
  plot.series.push_back({.name = "", .points = {{1.0, 1.0}}, .style = PlotStyle::kPoints});
  plot.series[1].colour = 4;
  const std::string svg = svg_from_plot(plot);
  EXPECT_EQ(count(svg, "class=\"dot c4\""), 1U);
  plot.series[1].name = "named";
  EXPECT_EQ(count(svg_from_plot(plot), "class=\"dot c4\""), 2U);
}

TEST(SvgPlot, HandlesAPlotWithoutData) {
  EXPECT_EQ(markup_fault(svg_from_plot({})), "");
  LinePlot plot = simple_plot();
  plot.series[0].points = {{1.0, 1.0}};
  EXPECT_EQ(markup_fault(svg_from_plot(plot)), "");
}

}  // namespace
}  // namespace raywalk
