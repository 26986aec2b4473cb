#include "build_lf/depth/depth_summary.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/depth_truth.h"
#include "build_lf/depth/map_images.h"
#include "core/base/error.h"
#include "core/files/test_json.h"
#include "core/files/test_support.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

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
                                      HasSubstr("views now use the distances estimated by sweep"),
                                      Not(HasSubstr("given"))));
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
  nlohmann::json expected = nlohmann::json::parse(R"({
    "maps": 2, "within_1px_share": 0.5, "within_2px_share": 0.75, "within_4px_share": 0.875,
    "median_relative_error": 0.02,
    "elsewhere": [
      {"confidence": 0.0625, "pixels": 1000, "wrong_share": 0.9, "median_error_px": 2.5}],
    "edges": [{"confidence": 0.3125, "pixels": 10, "wrong_share": 0.5, "median_error_px": 1.5}]
  })");
  expected["summary"] = text_of(*summary.truth);
  expect_keys(depth_document(summary)["truth"], expected);
}

TEST(ParallaxWarningsTest, NameTheLinesWithoutParallax) {
  const std::vector<MapSummary> maps{
      {.line = "x0", .parallax_share = 0.005}, {.line = "x0", .parallax_share = 0.5},
      {.line = "x1", .parallax_share = 0.9},   {.line = "z0", .parallax_share = 0.0},
      {.line = "z0", .parallax_share = 0.009}, {.line = "z1", .parallax_share = 0.02}};
  EXPECT_THAT(parallax_warnings(maps, 81.49),
              ::testing::ElementsAre(
                  AllOf(HasSubstr("line z0"), HasSubstr("81.5 m"), HasSubstr("did not move"))));
  EXPECT_THAT(parallax_warnings({}, 81.49), ::testing::IsEmpty());
}

constexpr PanoramaSize kTruthSize{64, 32};

class DepthTruthTest : public ::testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec small = room_of_scale(1.0);
    small.width = kTruthSize.width;
    return small;
  }
  // Maps at every eighth station: those of `scene`, modified by `change(map)`.
  template <typename Change>
  TruthComparison compare_maps_of(const SyntheticScene& scene, const Change& change) {
    PartialMaps partial(room_.room().directory(), "inputs");
    for (const SweepReference& reference : plan_.maps) {
      InverseDistanceMap map = true_map(scene, reference.position_m, plan_.size);
      map.station = reference.station;
      change(&map);
      partial.store(kFinalStage, map);
    }
    return compare_with_truth(GivenDistances(room_.room()), plan_, partial);
  }
  // Those of the room, modified by `change(pixel, map)`.
  template <typename Change>
  TruthComparison compare(const Change& change) {
    return compare_maps_of(spec().scene, [&](InverseDistanceMap* map) {
      for (size_t pixel = 0; pixel < map->inverse.size(); ++pixel) change(pixel, map);
    });
  }
  static void as_they_are(size_t, InverseDistanceMap*) {}
  // A pixel of parallax at the reach, 1/m.
  double pixel_per_m() const { return kTwoPi / kTruthSize.width / plan_.reach_m; }

  DepthTestRoom room_{spec()};
  DepthPlan plan_ = plan_depth(room_.room(), {.every = 8});
};

TEST_F(DepthTruthTest, ExactMapsHaveNoError) {
  room_.give_distances(spec().scene, kTruthSize);
  const TruthComparison comparison = compare(as_they_are);
  EXPECT_EQ(comparison.maps, 12);
  EXPECT_EQ(comparison.within_1px_share, 1.0);
  EXPECT_LT(comparison.median_relative_error, 1e-4);
  ASSERT_THAT(comparison.elsewhere, SizeIs(1));
  EXPECT_EQ(comparison.elsewhere[0].pixels, 12 * kTruthSize.width * kTruthSize.height);
  EXPECT_EQ(comparison.elsewhere[0].wrong_share, 0.0);
}

TEST_F(DepthTruthTest, CountsErrorsInPixelsOfParallax) {
  room_.give_distances(spec().scene, kTruthSize);
  // A quarter of the pixels each is off by 0.5, 1.5, 3 and 5 pixels.
  const TruthComparison comparison = compare([&](size_t pixel, InverseDistanceMap* map) {
    const std::array<double, 4> off_px{0.5, 1.5, 3.0, 5.0};
    map->inverse[pixel] += static_cast<float>(off_px[pixel % 4] * pixel_per_m());
  });
  EXPECT_DOUBLE_EQ(comparison.within_1px_share, 0.25);
  EXPECT_DOUBLE_EQ(comparison.within_2px_share, 0.5);
  EXPECT_DOUBLE_EQ(comparison.within_4px_share, 0.75);
}

TEST_F(DepthTruthTest, MedianErrorIsRelativeToTheDistance) {
  room_.give_distances(spec().scene, kTruthSize);
  for (const double error : {0.02, -0.05, 0.2}) {
    const TruthComparison comparison = compare([&](size_t pixel, InverseDistanceMap* map) {
      // A few gross errors do not move a median.
      map->inverse[pixel] *= static_cast<float>(pixel % 3 == 0 ? 100.0 : 1.0 + error);
    });
    EXPECT_NEAR(comparison.median_relative_error, std::fabs(error), 1e-4);
  }
}

TEST_F(DepthTruthTest, CalibrationGroupsErrorsByConfidence) {
  room_.give_distances(spec().scene, kTruthSize);
  const TruthComparison comparison = compare([&](size_t pixel, InverseDistanceMap* map) {
    const bool sure = pixel % 2 == 0;
    map->confidence[pixel] = sure ? 250 : 10;
    const bool wrong = sure ? pixel % 16 == 0 : pixel % 4 == 1;
    if (wrong) map->inverse[pixel] += static_cast<float>(3.0 * pixel_per_m());
  });
  ASSERT_THAT(comparison.elsewhere, SizeIs(2));
  const ConfidenceBand& unsure = comparison.elsewhere[0];
  const ConfidenceBand& sure = comparison.elsewhere[1];
  EXPECT_LT(unsure.confidence, 0.125);
  EXPECT_GT(sure.confidence, 0.875);
  EXPECT_EQ(unsure.pixels, sure.pixels);
  EXPECT_DOUBLE_EQ(unsure.wrong_share, 0.5);
  EXPECT_DOUBLE_EQ(sure.wrong_share, 0.125);
  EXPECT_LT(sure.median_error_px, 0.01);
}

// The scene has a box in front of a wall: 2 pixels beside its outline count with the edges.
TEST_F(DepthTruthTest, SilhouettesAreJudgedByThemselves) {
  SyntheticRoomSpec with_box = spec();
  with_box.scene.obstacle = SceneBox{{-0.2, -0.2, 0.9}, {0.2, 0.2, 1.0}};
  room_.give_distances(with_box.scene, kTruthSize);
  std::int64_t pixels = 0;
  const auto widen = [&](InverseDistanceMap* map) {
    const InverseDistanceMap without = true_map(spec().scene, map->position_m, plan_.size);
    for (size_t pixel = 0; pixel < map->inverse.size(); ++pixel, ++pixels) {
      const bool outline = pixel >= 2 && map->inverse[pixel] != without.inverse[pixel] &&
                           map->inverse[pixel - 2] == without.inverse[pixel - 2];
      if (outline) map->inverse[pixel - 2] = map->inverse[pixel];
    }
  };
  const TruthComparison comparison = compare_maps_of(with_box.scene, widen);
  ASSERT_THAT(comparison.edges, SizeIs(1));
  ASSERT_THAT(comparison.elsewhere, SizeIs(1));
  EXPECT_EQ(comparison.edges[0].pixels + comparison.elsewhere[0].pixels, pixels);
  EXPECT_LT(comparison.edges[0].pixels, pixels / 4);
  EXPECT_GT(comparison.edges[0].wrong_share, 0.05);
  EXPECT_EQ(comparison.elsewhere[0].wrong_share, 0.0);
}

TEST_F(DepthTruthTest, InfinityIsComparedAsParallax) {
  SyntheticScene sky = spec().scene;
  sky.infinitely_far = true;
  room_.give_distances(sky, kTruthSize);
  const TruthComparison right =
      compare([](size_t pixel, InverseDistanceMap* map) { map->inverse[pixel] = 0.0f; });
  EXPECT_EQ(right.within_1px_share, 1.0);
  EXPECT_TRUE(std::isfinite(right.median_relative_error));
  const TruthComparison wrong = compare([&](size_t pixel, InverseDistanceMap* map) {
    map->inverse[pixel] = static_cast<float>(1.5 * pixel_per_m());
  });
  EXPECT_EQ(wrong.within_1px_share, 0.0);
  EXPECT_EQ(wrong.within_2px_share, 1.0);
}

TEST_F(DepthTruthTest, ComparesMapsOfAnotherSize) {
  room_.give_distances(spec().scene, {4 * kTruthSize.width, 2 * kTruthSize.width});
  EXPECT_GT(compare(as_they_are).within_1px_share, 0.98);
}

TEST_F(DepthTruthTest, OnlyStationsWithBothMapsCountAndNoneIsAnError) {
  room_.give_distances(spec().scene, kTruthSize, 16);
  EXPECT_EQ(compare(as_they_are).maps, 8);
  EXPECT_FALSE(GivenDistances(room_.room()).inverse_of({0, 8}, kTruthSize).has_value());
  std::erase_if(plan_.maps,
                [](const SweepReference& map) { return map.station.station % 16 == 0; });
  EXPECT_THAT([&] { compare(as_they_are); }, ::testing::ThrowsMessage<Error>(HasSubstr("--every")));
}

TEST_F(DepthTruthTest, GivenDistancesAreFoundWhereOthersAreInUse) {
  EXPECT_TRUE(GivenDistances(room_.room()).empty());
  room_.give_distances(spec().scene, kTruthSize);
  const GivenDistances in_use(room_.room());
  const auto before = in_use.inverse_of({1, 4}, kTruthSize);
  ASSERT_TRUE(before.has_value());
  EXPECT_THAT(*before, ::testing::Each(::testing::Gt(0.0f)));
  const GivenDistances unused(Room::open_rays(room_.room().directory()));
  EXPECT_FALSE(unused.empty());
  EXPECT_EQ(unused.inverse_of({1, 4}, kTruthSize), before);
}

TEST(MapImagesTest, AreThreeOfEachMapEvenOfSky) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.width = 32;
  const DepthTestRoom room{spec};
  std::vector<InverseDistanceMap> maps(2, true_map(spec.scene, {0, 0, -0.5}, {32, 16}));
  for (float& inverse : maps[1].inverse) inverse = 0.0f;
  for (std::uint8_t& confidence : maps[1].confidence) confidence = 0;
  const std::vector<ReportImage> images = map_images(room.room(), maps);
  ASSERT_EQ(images.size(), 6U);
  EXPECT_EQ(images[0].row, "line x0, station 0");
  EXPECT_EQ(images[1].caption, "inverse distance");
  EXPECT_TRUE(images[5].source.starts_with("data:image/jpeg"));
}

}  // namespace
}  // namespace raywalk::build_lf
