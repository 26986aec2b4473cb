#include "render/web/web_plan.h"

#include <gmock/gmock.h>

#include <limits>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/view/test_room.h"
#include "render/web/hotspots.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

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

TEST(WebPlan, KeepsAllWhereNothingWasMeasured) {
  const TestRoom room(box_room(96));
  const WebPlan all = plan(room.room());
  EXPECT_EQ(all.stations, 52);
  EXPECT_EQ(all.captured_stations, 52);
  EXPECT_EQ(all.width, 96);
  EXPECT_EQ(all.distance_width, 96);
  EXPECT_THAT(all.summary, HasSubstr("all 52; raywalk-build-lf require"));
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
}

TEST(WebPlan, PrefersStationsWithDistances) {
  SyntheticRoomSpec spec = box_room(32);
  spec.distance_every = 3;
  const TestRoom room(spec);
  // The ends and the corners of the cell (2 and 10) are always kept.
  EXPECT_THAT(plan(room.room(), requirements(0.4, kInfinity, 32)).kept[0],
              ElementsAre(0, 2, 3, 6, 9, 10, 12));
}

TEST(WebPlan, DistancesAreNoWiderThanTheMaps) {
  SyntheticRoomSpec spec = box_room(96);
  spec.distance_width = 24;
  EXPECT_EQ(plan(TestRoom(spec).room()).distance_width, 24);
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
  SyntheticRoomSpec spec = box_room(32);
  spec.cells_x = spec.cells_z = 3;
  const Grid grid = synthetic_grid(spec);
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
