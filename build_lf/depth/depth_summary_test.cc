#include "build_lf/depth/depth_summary.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "core/base/test_error.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

DepthSummary some_summary() {
  DepthSummary summary{.room = "room.lf",
                       .method = "sweep",
                       .size = {256, 128},
                       .stations = 68,
                       .reach_m = 0.5,
                       .nearest_m = 0.25,
                       .layers = 96,
                       .largest_exposure_step = 1.3,
                       .seconds = 12.5,
                       .peak_memory_mb = 321.0,
                       .distances = "estimated by sweep"};
  summary.maps = {{"x0", 4, "front_4.png", 0.75, 0.125, 1.0},
                  {"z1", 0, "right_0.png", 0.5, 0.25, 0.375}};
  summary.frame_findings = {{{0, 7}, "front_7.png", FrameFault::kExposureStep, {0, 6}, 1.3}};
  summary.warnings = {"the exposure of front_7.png is 1.30 times that of front_6.png"};
  return summary;
}

TEST(DepthSummaryTest, EveryFigureHasItsKey) {
  const auto json = depth_document(some_summary());
  EXPECT_EQ(json["format"], "raywalk-depth");
  EXPECT_EQ(json["format_version"], 1);
  EXPECT_EQ(json["room"], "room.lf");
  EXPECT_EQ(json["method"], "sweep");
  EXPECT_EQ(json["width"], 256);
  EXPECT_EQ(json["height"], 128);
  EXPECT_EQ(json["stations"], 68);
  EXPECT_EQ(json["reach_m"], 0.5);
  EXPECT_EQ(json["nearest_m"], 0.25);
  EXPECT_EQ(json["layers"], 96);
  EXPECT_EQ(json["largest_exposure_step"], 1.3);
  EXPECT_EQ(json["seconds"], 12.5);
  EXPECT_EQ(json["peak_memory_mb"], 321.0);
  EXPECT_EQ(json["warnings"].size(), 1U);
  ASSERT_EQ(json["frame_findings"].size(), 1U);
  EXPECT_EQ(json["frame_findings"][0]["file"], "front_7.png");
  EXPECT_EQ(json["frame_findings"][0]["fault"], "exposure_step");
  EXPECT_EQ(json["frame_findings"][0]["measure"], 1.3);
  ASSERT_EQ(json["maps"].size(), 2U);
  EXPECT_EQ(json["maps"][0]["line"], "x0");
  EXPECT_EQ(json["maps"][0]["station"], 4);
  EXPECT_EQ(json["maps"][0]["file"], "front_4.png");
  EXPECT_EQ(json["maps"][1]["mean_confidence"], 0.5);
  EXPECT_EQ(json["maps"][1]["low_share"], 0.25);
  EXPECT_EQ(json["maps"][1]["parallax_share"], 0.375);
  EXPECT_TRUE(json["truth"].is_null());
  EXPECT_TRUE(json["gains"].is_null());
  EXPECT_EQ(json["distances"], "estimated by sweep");
  EXPECT_EQ(json["low_confidence_share"], 0.1875);
  EXPECT_NEAR(json["low_confidence_below"], 0.25, 0.002);
}

TEST(DepthSummaryTest, MostlyUnknownDistancesAreNotUsable) {
  DepthSummary summary = some_summary();
  require_usable(summary);
  for (MapSummary& map : summary.maps) map.low_share = 0.75;
  EXPECT_THAT(error_of([&] { require_usable(summary); }),
              AllOf(HasSubstr("room.lf: not usable between stations"), HasSubstr("75 %")));
}

TEST(DepthSummaryTest, TextSaysWhatWasMadeAndWhatViewsUse) {
  DepthSummary summary = some_summary();
  EXPECT_THAT(text_of(summary), AllOf(HasSubstr("2 distance maps of 256 x 128"),
                                      HasSubstr("low confidence (below 0.25) in 18.8 % of"),
                                      HasSubstr("views now use the distances estimated by sweep")));
  EXPECT_THAT(text_of(summary), Not(HasSubstr("given")));
  summary.truth =
      TruthComparison{.maps = 2, .within_1px_share = 0.5, .median_relative_error = 0.02};
  summary.kept_given = "room.lf/distances-given";
  EXPECT_THAT(text_of(summary),
              AllOf(HasSubstr("compared with the given distances, 2 maps: 50.0 % of the pixels"),
                    HasSubstr("median error of the distance 2.00 %"),
                    HasSubstr("kept in room.lf/distances-given"), HasSubstr("--use given")));
  summary.hold_out = 8;
  summary.distances = "given";
  EXPECT_THAT(text_of(summary),
              AllOf(HasSubstr("as before: given"), Not(HasSubstr("views now use"))));
}

TEST(DepthSummaryTest, TruthIsPresentIfCompared) {
  DepthSummary summary = some_summary();
  summary.truth = TruthComparison{
      2, 0.5, 0.75, 0.875, 0.02, {{0.0625, 1000, 0.9, 2.5}}, {{0.3125, 10, 0.5, 1.5}}};
  const auto truth = depth_document(summary)["truth"];
  EXPECT_EQ(truth["maps"], 2);
  EXPECT_EQ(truth["within_1px_share"], 0.5);
  EXPECT_EQ(truth["within_2px_share"], 0.75);
  EXPECT_EQ(truth["within_4px_share"], 0.875);
  EXPECT_EQ(truth["median_relative_error"], 0.02);
  EXPECT_EQ(truth["summary"], text_of(*summary.truth));
  ASSERT_EQ(truth["elsewhere"].size(), 1U);
  EXPECT_EQ(truth["elsewhere"][0]["confidence"], 0.0625);
  EXPECT_EQ(truth["elsewhere"][0]["pixels"], 1000);
  EXPECT_EQ(truth["elsewhere"][0]["wrong_share"], 0.9);
  EXPECT_EQ(truth["elsewhere"][0]["median_error_px"], 2.5);
  ASSERT_EQ(truth["edges"].size(), 1U);
  EXPECT_EQ(truth["edges"][0]["pixels"], 10);
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
