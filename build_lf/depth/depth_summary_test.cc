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

// Expects the keys of `expected` with its values, in whatever order and beside others.
void expect_keys(const nlohmann::json& document, const nlohmann::json& expected) {
  for (const auto& [key, value] : expected.items()) EXPECT_EQ(document[key], value) << key;
}

TEST(DepthSummaryTest, EveryFigureHasItsKey) {
  const nlohmann::json document = depth_document(some_summary());
  expect_keys(document, nlohmann::json::parse(R"({
    "format": "raywalk-depth", "format_version": 1, "room": "room.lf", "method": "sweep",
    "width": 256, "height": 128, "stations": 68, "reach_m": 0.5, "nearest_m": 0.25, "layers": 96,
    "largest_exposure_step": 1.3, "seconds": 12.5, "peak_memory_mb": 321.0,
    "warnings": ["the exposure of front_7.png is 1.30 times that of front_6.png"],
    "truth": null, "gains": null, "distances": "estimated by sweep", "low_confidence_share": 0.1875
  })"));
  EXPECT_NEAR(document["low_confidence_below"], 0.25, 0.002);
  ASSERT_EQ(document["frame_findings"].size(), 1U);
  expect_keys(document["frame_findings"][0],
              {{"file", "front_7.png"}, {"fault", "exposure_step"}, {"measure", 1.3}});
  ASSERT_EQ(document["maps"].size(), 2U);
  expect_keys(document["maps"][0], {{"line", "x0"}, {"station", 4}, {"file", "front_4.png"}});
  expect_keys(document["maps"][1],
              {{"mean_confidence", 0.5}, {"low_share", 0.25}, {"parallax_share", 0.375}});
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
  const nlohmann::json truth = depth_document(summary)["truth"];
  expect_keys(truth, {{"maps", 2},
                      {"within_1px_share", 0.5},
                      {"within_2px_share", 0.75},
                      {"within_4px_share", 0.875},
                      {"median_relative_error", 0.02},
                      {"summary", text_of(*summary.truth)}});
  ASSERT_EQ(truth["elsewhere"].size(), 1U);
  expect_keys(
      truth["elsewhere"][0],
      {{"confidence", 0.0625}, {"pixels", 1000}, {"wrong_share", 0.9}, {"median_error_px", 2.5}});
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
