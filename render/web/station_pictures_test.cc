// What stations hold of an export: their pictures and distances, and which of them are exported.
#include "render/web/station_pictures.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/view/test_room.h"
#include "render/web/hotspots.h"
#include "render/web/station_distances.h"
#include "render/web/web_plan.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

SyntheticRoomSpec room_with_dolly(int width, bool masked) {
  SyntheticRoomSpec spec = box_room(width);
  spec.companion = masked_below(-std::cos(radians_from_degrees(22.0)));
  spec.companion->masked = masked;
  return spec;
}

// In front of every fourth station.
CameraCompanion visitor() {
  return {.hides =
              [](const std::string&, int station, const Eigen::Vector3d& direction) {
                return station % 4 == 1 && direction.x() > 0.9;
              },
          .masked = false,
          .left_out = true};
}

cv::Mat picture_of(const Room& room, int line, int station, int width) {
  StationDistances distances(room, width / 2);
  StationPictures pictures(room, {.method = ViewMethod::kTwoSided, .width = width});
  return pictures.picture_of(line, station, distances.seen_from(line, station));
}

const Eigen::Vector3d& position_m(const Room& room, int line, int station) {
  return room.grid().station({line, station}).position_m;
}

cv::Mat truth_at(const TestRoom& room, int line, int station, int width) {
  const Eigen::Vector3d& at_m = position_m(room.room(), line, station);
  return room.truth({at_m.x(), at_m.z()}, width);
}

cv::Mat averaged(const cv::Mat& picture, int width) {
  cv::Mat smaller;
  cv::resize(picture, smaller, {width, width / 2}, 0.0, 0.0, cv::INTER_AREA);
  return smaller;
}

// Pixels of the companions' magenta, which no wall has.
int companion_pixels(const cv::Mat& picture) {
  cv::Mat found;
  cv::inRange(picture, cv::Scalar(230, 0, 230), cv::Scalar(255, 25, 255), found);
  return cv::countNonZero(found);
}

cv::Mat lowest_rows(const cv::Mat& picture) {
  return picture.rowRange(picture.rows * 7 / 8, picture.rows).clone();
}

TEST(StationPictures, AreTheCapturedOnesWhereAllIsShown) {
  const TestRoom room(box_room(96));
  EXPECT_EQ(largest_difference(picture_of(room.room(), 0, 6, 96), truth_at(room, 0, 6, 96)), 0.0);
  EXPECT_EQ(
      largest_difference(picture_of(room.room(), 0, 6, 48), averaged(truth_at(room, 0, 6, 96), 48)),
      0.0);
  EXPECT_TRUE(hidden_in_views(room.room(), 0, 6, 96).empty());
}

TEST(StationPictures, MaskedOnesAreCompletedFromOtherStations) {
  const TestRoom shown(room_with_dolly(192, false)), room(room_with_dolly(192, true));
  ASSERT_GT(companion_pixels(picture_of(shown.room(), 0, 6, 192)), 1000);
  // In the middle of a line, at a corner, and beyond the cells, where no view can be rendered.
  for (const int station : {6, 10, 0, 12}) {
    const cv::Mat picture = picture_of(room.room(), 0, station, 192);
    EXPECT_EQ(companion_pixels(picture), 0) << station;
    const cv::Mat truth = truth_at(room, 0, station, 192);
    EXPECT_GT(psnr_db(lowest_rows(picture), lowest_rows(truth)), 26.0) << station;
    const cv::Rect above(0, 0, 192, 80);
    EXPECT_EQ(largest_difference(picture(above).clone(), truth(above).clone()), 0.0);
  }
}

TEST(StationPictures, WhatViewsLeaveOutIsCompletedToo) {
  const TestRoom room({.overhang_m = 0.25, .width = 96, .companion = visitor()});
  ASSERT_GT(companion_pixels(captured_picture_at(room.room(), 0, 5, 96)), 100);
  for (const int width : {96, 64}) {
    const cv::Mat picture = picture_of(room.room(), 0, 5, width);
    EXPECT_EQ(companion_pixels(picture), 0);
    EXPECT_GT(psnr_db(picture, truth_at(room, 0, 5, width)), 30.0);
  }
  EXPECT_TRUE(hidden_in_views(room.room(), 0, 4, 96).empty());
}

TEST(StationPictures, MarksWhatIsHiddenInPart) {
  const TestRoom room(room_with_dolly(96, true));
  // At 40 pixels the dolly's edge runs through pixels: nothing of the dolly may be mixed into a
  // pixel that is kept.
  cv::Mat picture = captured_picture_at(room.room(), 0, 6, 40);
  picture.setTo(cv::Scalar(0, 0, 0), hidden_in_views(room.room(), 0, 6, 40));
  const cv::Mat truth = averaged(truth_at(room, 0, 6, 96), 40);
  const cv::Mat kept = ~hidden_in_views(room.room(), 0, 6, 40);
  EXPECT_GT(psnr_db(picture, truth, kept), 50.0);
  EXPECT_GT(cv::countNonZero(kept), 40 * 20 * 8 / 10);
}

TEST(StationPictures, HaveTheirGainsApplied) {
  SyntheticRoomSpec spec = box_room(96);
  const TestRoom even(spec);
  spec.line_gain = {{"x0", 0.8}};
  const RoomWithGains room(spec, [](int line, int) {
    return line == 0 ? GainField{.whole = {1.25F, 1.25F, 1.25F}} : GainField{};
  });
  const Room bare = Room::open_without_gains(room.room().directory());
  const cv::Mat truth = truth_at(even, 0, 6, 96);
  EXPECT_GT(psnr_db(captured_picture_at(room.room(), 0, 6, 96), truth), 50.0);
  EXPECT_LT(psnr_db(captured_picture_at(bare, 0, 6, 96), truth), 25.0);
}

double true_inverse(const TestRoom& room, int line, int station, const InverseMap& map, int theta,
                    int row) {
  return 1.0 / distance_at(room.spec().scene, position_m(room.room(), line, station),
                           direction_from_angles(
                               angles_from_pixel({double(theta), double(row)}, map.size())));
}

// Share of the pixels within 3 % of the truth.
double share_right(const TestRoom& room, int line, int station, const InverseMap& map) {
  int right = 0;
  for (int theta = 0; theta < map.size().width; ++theta) {
    for (int row = 0; row < map.size().height; ++row) {
      const double truth = true_inverse(room, line, station, map, theta, row);
      if (std::abs(map.at(theta, row) - truth) <= 0.03 * truth) ++right;
    }
  }
  return static_cast<double>(right) / static_cast<double>(map.values().size());
}

bool complete(const InverseMap& map) {
  return std::ranges::all_of(
      map.values(), [](float inverse) { return std::isfinite(inverse) && inverse >= 0.0F; });
}

TEST(StationDistances, AreThoseOfTheStationsOwnMap) {
  const TestRoom room(box_room(64));
  const InverseMap map = StationDistances(room.room(), 64).seen_from(1, 5);
  for (int theta = 0; theta < 64; ++theta) {
    for (int row = 0; row < 32; ++row) {
      const double truth = true_inverse(room, 1, 5, map, theta, row);
      EXPECT_NEAR(map.at(theta, row), truth, 1e-6 * truth) << theta << ',' << row;
    }
  }
}

TEST(StationDistances, AreRightWithoutAnOwnMapAndAtOtherWidths) {
  const TestRoom room({.overhang_m = 0.25, .distance_every = 3});
  for (const int width : {128, 64, 44}) {
    StationDistances distances(room.room(), width);
    for (const int station : {0, 1, 7, 12}) {
      const InverseMap map = distances.seen_from(2, station);
      EXPECT_EQ(map.size().width, width);
      EXPECT_TRUE(complete(map));
      EXPECT_GT(share_right(room, 2, station, map), 0.93) << width << " at " << station;
    }
  }
}

TEST(StationDistances, DoNotMixSurfacesAtSilhouettes) {
  const TestRoom room({.scene = {.obstacle = SceneBox{{-0.15, -1.2, -0.15}, {0.15, 0.6, 0.15}}},
                       .overhang_m = 0.25,
                       .width = 256});
  const InverseMap map = StationDistances(room.room(), 64).seen_from(0, 6);
  // In the middle row the obstacle is 0.35 m away or more than 0.7 m nearer than any wall.
  for (int theta = 0; theta < 64; ++theta) {
    const float inverse = map.at(theta, 16);
    EXPECT_TRUE(inverse > 1.8F || inverse < 0.65F) << theta << ": " << 1.0F / inverse << " m";
  }
}

TEST(StationDistances, FillWhatTheMapsDoNotKnowAsViewsDo) {
  SyntheticRoomSpec spec = box_room(64);
  // Nothing is known of a part of the walls and of the zenith, from anywhere.
  spec.stored_confidence = [](int u, int v) -> std::uint8_t {
    return v < 6 || (u > 20 && u < 40 && v > 10 && v < 20) ? 0 : 255;
  };
  const TestRoom room(spec);
  const InverseMap map = StationDistances(room.room(), 64).seen_from(3, 6);
  EXPECT_TRUE(complete(map));
  EXPECT_GT(share_right(room, 3, 6, map), 0.6) << "of the 73 % that are known, most";

  DistanceView view(room.room());
  const Eigen::Vector3d& at_m = position_m(room.room(), 3, 6);
  const MapSpread spread = map_spread(room.room().grid(), {at_m.x(), at_m.z()});
  const std::vector<int> lines{0, 1, 2, 3};
  view.compute(nearest_maps(room.room(), lines, at_m, spread.gap_m, spread.most_per_line,
                            ViewOptions().distance_maps),
               at_m);
  EXPECT_EQ(map.at(30, 15), view.column(30)[15]);
  EXPECT_EQ(map.at(3, 2), view.column(3)[2]);
  EXPECT_GT(map.at(30, 15), 0.0F);
}

TEST(StationDistances, AreIgnoredBelowTheConfidenceOfViews) {
  SyntheticRoomSpec spec = box_room(64);
  spec.stored_distance = [](int u, int v, double exact_m) {
    return static_cast<float>(u == 10 && v == 16 ? 0.01 : exact_m);
  };
  spec.stored_confidence = [](int u, int v) -> std::uint8_t {
    return u == 10 && v == 16 ? kMinConfidence - 1 : 255;
  };
  const TestRoom room(spec);
  EXPECT_LT(StationDistances(room.room(), 64).seen_from(0, 6).at(10, 16), 2.0F);
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ConnectionRule rule(double k_deg) {
  return {radians_from_degrees(k_deg), radians_from_degrees(5.0)};
}

RoomRequirements requirements(double spacing_m, double worth_width_px, int distance_width_px) {
  return {.spacing_m = spacing_m,
          .worth_width_px = worth_width_px,
          .distance_width_px = distance_width_px};
}

WebPlan plan(const Room& room, const std::optional<RoomRequirements>& required = {},
             double budget_mb = 256.0, int width_px = 0) {
  return plan_export(room, required, {budget_mb, width_px, rule(90.0)});
}

TEST(WebPlan, CountsMemoryOfPanoramasCoarseOnesAndDistances) {
  EXPECT_NEAR(gpu_mb(250, 1024, 0), 524.288 + 250 * 0.131072, 1e-9);
  EXPECT_NEAR(gpu_mb(1, 1024, 512), 2.097152 + 0.131072 + 0.262144, 1e-9);
}

TEST(WebPlan, HoldsWhatTheSceneRequires) {
  const TestRoom room(box_room(96));
  const WebPlan thin = plan(room.room(), requirements(0.25, 62.5, 20));
  EXPECT_THAT(thin.kept[0], ElementsAre(0, 2, 4, 6, 8, 10, 12));
  EXPECT_EQ(thin.stations, 28);
  EXPECT_EQ(thin.width, 64) << "62.5, rounded up to a multiple of 4";
  EXPECT_EQ(thin.distance_width, 20);
  EXPECT_EQ(plan(room.room(), requirements(0.25, kInfinity, 96)).width, 96);
  EXPECT_EQ(plan(room.room(), requirements(0.25, 1e9, 96)).distance_width, 96);
  EXPECT_EQ(plan(room.room(), {}, 256.0, 70).width, 68) << "asked for";
  EXPECT_EQ(plan(room.room(), {}, 256.0, 4096).width, 96) << "no more than captured";
  EXPECT_EQ(plan(TestRoom({.width = 96, .distance_width = 24}).room()).distance_width, 24);
}

TEST(WebPlan, PrefersStationsWithDistances) {
  const TestRoom room({.overhang_m = 0.25, .width = 32, .distance_every = 3});
  // The ends and the corners of the cell (2 and 10) are always kept.
  EXPECT_THAT(plan(room.room(), requirements(0.4, kInfinity, 32)).kept[0],
              ElementsAre(0, 2, 3, 6, 9, 10, 12));
}

// Written once.
const TestRoom& wide_room() {
  static const TestRoom room(box_room(512));
  return room;
}

TEST(WebPlan, TheBudgetReducesBothWidths) {
  const TestRoom& room = wide_room();
  const WebPlan all = plan(room.room());
  ASSERT_EQ(all.width, 512);
  const double needed_mb = gpu_mb(all.resident_stations, 512, 512);
  EXPECT_EQ(plan(room.room(), {}, 1.001 * needed_mb).width, 512);
  const WebPlan less = plan(room.room(), {}, 0.5 * needed_mb);
  EXPECT_LT(less.width, 370);
  EXPECT_GT(less.width, 310);
  EXPECT_NEAR(less.distance_width, less.width, 4);
  EXPECT_LE(gpu_mb(less.resident_stations, less.width, less.distance_width), 0.5 * needed_mb);
  EXPECT_EQ(less.stations, all.stations);
  EXPECT_THAT(less.summary, HasSubstr("hold the stations of one cell"));
}

TEST(WebPlan, ATooSmallBudgetIsToldTheLeast) {
  const TestRoom& room = wide_room();
  const std::string error = error_of([&] { plan(room.room(), {}, 1.0); });
  const auto at = error.find("need ");
  ASSERT_NE(at, std::string::npos) << error;
  const double least_mb = std::stod(error.substr(at + 5));
  EXPECT_EQ(plan(room.room(), {}, least_mb).width, 256);
  EXPECT_THAT(error_of([&] { plan(room.room(), {}, least_mb - 1.0); }), HasSubstr("--budget-mb"));
}

TEST(WebPlan, OneCellReadsOnlyTheStationsAroundIt) {
  const Grid grid = synthetic_grid({.cells_x = 3, .cells_z = 3, .overhang_m = 0.25});
  // Each of the four lines of a cell has 29 stations, 9 of them along its sides.
  const int at_90 = most_stations_of_a_cell(grid, rule(90.0));
  EXPECT_GE(at_90, 4 * 9);
  EXPECT_LE(at_90, 4 * 19) << "connected near the corners";
  EXPECT_GT(most_stations_of_a_cell(grid, rule(45.0)), at_90) << "connected beyond them";
}

TEST(WebPlan, AllStationsServeALineWithoutCells) {
  const TestRoom room({.cells_z = 0, .width = 32});
  EXPECT_EQ(plan(room.room()).resident_stations, plan(room.room()).stations);
}

class HotspotsTest : public ::testing::Test {
 protected:
  std::vector<Hotspot> read(const std::string& text) const {
    write_file_atomically(directory_ / "spots.json", text);
    return read_hotspots(directory_ / "spots.json");
  }
  std::string error(const std::string& text) const {
    return error_of([&] { read(text); });
  }
  static std::string with_link(const std::string& link) {
    return R"([{"x_m": 0, "y_m": 0, "z_m": 0, "text": "a", "link": ")" + link + R"("}])";
  }

  TestDirectory directory_;
};

TEST_F(HotspotsTest, ReadsPointsWithAndWithoutLinks) {
  const auto spots = read(R"([
    {"x_m": 0.5, "y_m": -1, "z_m": 2e-1, "text": "A chair", "link": "https://example.org/a?b#c"},
    {"x_m": 0, "y_m": 0, "z_m": 0, "text": "Nothing"}])");
  ASSERT_EQ(spots.size(), 2U);
  EXPECT_EQ(spots[0].position_m, Eigen::Vector3d(0.5, -1.0, 0.2));
  EXPECT_EQ(spots[0].text, "A chair");
  EXPECT_EQ(spots[0].link, "https://example.org/a?b#c");
  EXPECT_EQ(spots[1].link, "");
  EXPECT_TRUE(read("[]").empty());
}

TEST_F(HotspotsTest, TakesRelativeLinks) {
  for (const char* link :
       {"about.html", "../more/chair.html#top", "/rooms/2", "a?at=1:2", "HTTP://x"}) {
    EXPECT_EQ(error(with_link(link)), "no error") << link;
  }
}

TEST_F(HotspotsTest, RefusesLinksThatRunSomethingOrLeadElsewhere) {
  for (const char* link :
       {"javascript:alert(1)", "JavaScript:x", " javascript:x", "java\\tscript:x",
        "data:text/html,x", "//host/a", "\\\\\\\\host", "mailto:a@b", ""}) {
    EXPECT_THAT(error(with_link(link)),
                AllOf(HasSubstr("spots.json"), HasSubstr("[0]"), HasSubstr("relative path")))
        << link;
  }
}

TEST_F(HotspotsTest, ErrorsNameFileAndEntry) {
  const std::string good = R"({"x_m": 0, "y_m": 0, "z_m": 0, "text": "a"})";
  const std::vector<std::pair<std::string, std::vector<std::string>>> wrong{
      {R"({"x_m": 0, "y_m": 0, "z_m": 0, "text": "a", "colour": 1})",
       {"spots.json", "[1]", "colour", "unknown key"}},
      {R"({"x_m": 0, "y_m": 0, "text": "a"})", {"[1]", "z_m"}},
      {R"({"x_m": "0", "y_m": 0, "z_m": 0, "text": "a"})", {"[1]", "x_m"}},
      {R"({"x_m": 1e400, "y_m": 0, "z_m": 0, "text": "a"})", {"spots.json"}},
      {R"({"x_m": 1e9, "y_m": 0, "z_m": 0, "text": "a"})", {"[1]", "x_m"}},
      {R"({"x_m": 0, "y_m": 0, "z_m": 0, "text": ""})", {"[1]", "empty"}},
      {"3", {"[1]"}}};
  for (const auto& [entry, said] : wrong) {
    const std::string message = error("[" + good + "," + entry + "]");
    for (const std::string& part : said) EXPECT_THAT(message, HasSubstr(part)) << entry;
  }
  EXPECT_THAT(error("{}"), HasSubstr("spots.json"));
  EXPECT_THAT(error("[,]"), HasSubstr("spots.json"));
  EXPECT_THAT(error_of([&] { read_hotspots(directory_ / "none.json"); }), HasSubstr("none.json"));
}

}  // namespace
}  // namespace raywalk::render
