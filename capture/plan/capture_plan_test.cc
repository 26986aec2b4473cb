#include "capture/plan/capture_plan.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "capture/plan/line_selection.h"
#include "capture/plan/plan_report.h"
#include "core/base/error.h"
#include "core/files/test_support.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// One cell of 1 m, stations 50 mm apart, on a rail of 2 m, unless a test says otherwise.
class CapturePlanTest : public testing::Test {
 protected:
  CapturePlanTest() {
    config_.grid.spacing_mm = 50.0;
    config_.slider.high_limit_mm = 2000.0;
  }
  void set_width_px(int width_px) {
    config_.camera.width_px = width_px;
    config_.camera.height_px = width_px / 2;
  }
  CapturePlan plan() const { return plan_capture(config_); }
  std::string refusal() const {
    return error_of([this] { plan(); });
  }
  std::string as_json() const { return plan_json(plan(), config_.camera); }
  PlanJson report() const { return plan_report(plan(), config_); }
  std::string text() const { return plan_report_text(report()); }

  CaptureConfig config_;
};

std::vector<std::string> ids_of(const CapturePlan& plan) {
  std::vector<std::string> ids;
  for (const CaptureLine& line : plan.lines) ids.push_back(line.id);
  return ids;
}

const CaptureLine& line_of(const CapturePlan& plan, std::string_view id) {
  return *std::ranges::find(plan.lines, id, &CaptureLine::id);
}

TEST_F(CapturePlanTest, OneCellHasFourLinesThatReachBeyondItsCorners) {
  const CapturePlan plan = this->plan();
  ASSERT_EQ(plan.lines.size(), 4u);
  // 1 / tan(76 - 2.5 deg) = 0.2962, rounded up to steps of 0.05.
  EXPECT_NEAR(plan.overhang_m, 0.3, 1e-12);
  EXPECT_EQ(plan.stations(), 4u * 33u);
  const CaptureLine& back = line_of(plan, "x0");
  EXPECT_EQ(back.axis, LineAxis::kX);
  EXPECT_EQ(back.across_m, -0.5);
  EXPECT_NEAR(back.stations.front().position_m.x_m, -0.8, 1e-12);
  EXPECT_NEAR(back.stations.back().position_m.x_m, 0.8, 1e-12);
  EXPECT_EQ(back.stations.front().position_m.z_m, -0.5);
  const CaptureLine& right = line_of(plan, "z1");
  EXPECT_EQ(right.axis, LineAxis::kZ);
  EXPECT_EQ(right.across_m, 0.5);
  EXPECT_NEAR(right.stations[6].position_m.z_m, -0.5, 1e-12);
  EXPECT_EQ(right.stations[6].position_m.x_m, 0.5);
}

TEST_F(CapturePlanTest, StationsAreNamedInOrderAndPlacedOnTheRail) {
  config_.slider.first_station_mm = 50.0;
  const CaptureLine line = plan().lines.front();
  EXPECT_EQ(line.stations[0].name, "x0_000");
  EXPECT_EQ(line.stations[0].rail_mm, 50.0);
  EXPECT_EQ(line.stations[32].name, "x0_032");
  EXPECT_NEAR(line.stations[32].rail_mm, 50.0 + 1600.0, 1e-9);
  config_.grid.spacing_mm = 0.5;
  const std::vector<CaptureStation> many = plan().lines.front().stations;
  EXPECT_EQ(many[0].name, "x0_0000");
  EXPECT_TRUE(std::ranges::is_sorted(many, {}, &CaptureStation::name));
}

TEST_F(CapturePlanTest, LinesAreInTheOrderOfTheGridAndCentred) {
  config_.grid.cells_x = 2;
  config_.grid.overhang_mm = 0.0;
  const CapturePlan plan = this->plan();
  EXPECT_THAT(ids_of(plan), ElementsAre("x0", "x1", "z0", "z1", "z2"));
  EXPECT_EQ(line_of(plan, "x0").stations.size(), 41u);
  EXPECT_EQ(line_of(plan, "z0").stations.size(), 21u);
  EXPECT_EQ(line_of(plan, "z0").across_m, -1.0);
  EXPECT_EQ(line_of(plan, "z1").across_m, 0.0);
  EXPECT_EQ(plan.overhang_m, 0.0);
}

// Later stages rely on it: corners of cells are stations of both lines.
TEST_F(CapturePlanTest, EveryCornerIsAStationOfBothItsLines) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    const int steps = std::uniform_int_distribution(1, 40)(random);
    config_.grid.cells_x = std::uniform_int_distribution(1, 4)(random);
    config_.grid.cells_z = std::uniform_int_distribution(1, 4)(random);
    config_.grid.cell_side_m = std::exp(std::uniform_real_distribution(-4.0, 4.0)(random));
    config_.grid.spacing_mm = config_.grid.cell_side_m * 1e3 / steps;
    config_.grid.k_deg = std::uniform_real_distribution(45.0, 90.0)(random);
    config_.slider.high_limit_mm = 1e9;
    const CapturePlan plan = this->plan();
    EXPECT_GE(plan.overhang_m, overhang_needed_m(config_.grid) * (1.0 - 1e-3));
    const double tolerance_m = 1e-9 * config_.grid.cell_side_m;
    for (const CaptureLine& along : plan.lines) {
      for (const CaptureLine& across : plan.lines) {
        if (along.axis == across.axis) continue;
        const bool has_corner =
            std::any_of(along.stations.begin(), along.stations.end(), [&](const auto& station) {
              const double along_m =
                  along.axis == LineAxis::kX ? station.position_m.x_m : station.position_m.z_m;
              return std::abs(along_m - across.across_m) <= tolerance_m;
            });
        ASSERT_TRUE(has_corner) << along.id << " " << across.id << " " << i;
      }
    }
  }
}

// overhang_needed_m against the positions on the lines read by viewpoints throughout the cell.
TEST(OverhangNeeded, IsTheFarthestThatAClampedConnectionReads) {
  for (const double k_deg : {48.0, 60.0, 76.0, 85.0}) {
    CaptureGrid grid;
    grid.k_deg = k_deg;
    const double k = radians_from_degrees(k_deg);
    const double nearest = radians_from_degrees(k_deg - 2.5);
    double farthest_m = 0.0;
    for (int i = 0; i <= 100; ++i) {
      for (int j = 0; j <= 100; ++j) {
        const double a = i / 100.0, b = j / 100.0;
        if (std::atan2(a, b) < k) continue;
        farthest_m = std::max(farthest_m, a / std::tan(nearest) - b);
      }
    }
    EXPECT_NEAR(overhang_needed_m(grid), farthest_m, 1e-12) << k_deg;
  }
  EXPECT_NEAR(overhang_needed_m(CaptureGrid{}), 0.296, 5e-4);
}

TEST(AngleReached, FallsFrom90ToKAsTheOverhangGrows) {
  const CaptureGrid grid;
  EXPECT_EQ(angle_reached_deg(grid, 0.0), 90.0);
  EXPECT_NEAR(angle_reached_deg(grid, std::tan(radians_from_degrees(10.0))), 80.0, 1e-9);
  EXPECT_EQ(angle_reached_deg(grid, overhang_needed_m(grid)), 76.0);
}

TEST_F(CapturePlanTest, ValidationLinesComeLastAndAreMarked) {
  config_.validation = {{LineAxis::kX, 0.1, -0.4, 0.4, 200.0},
                        {LineAxis::kZ, 0.0, -0.3, 0.3, 300.0}};
  const CapturePlan plan = this->plan();
  ASSERT_EQ(plan.lines.size(), 6u);
  EXPECT_FALSE(plan.lines[3].validation);
  const CaptureLine& first = plan.lines[4];
  EXPECT_EQ(first.id, "v0");
  EXPECT_TRUE(first.validation);
  ASSERT_EQ(first.stations.size(), 5u);
  EXPECT_EQ(first.stations[0].name, "v0_000");
  EXPECT_NEAR(first.stations[4].position_m.x_m, 0.4, 1e-12);
  EXPECT_EQ(first.stations[4].position_m.z_m, 0.1);
  EXPECT_EQ(first.stations[0].rail_mm, config_.slider.first_station_mm);
  EXPECT_EQ(plan.lines[5].axis, LineAxis::kZ);
}

// Each is refused with a message that has this text.
TEST_F(CapturePlanTest, ImpossiblePlansAreRefusedWithTheSettingToChange) {
  struct Case {
    std::function<void(CaptureConfig* config)> change;
    std::string message;
  };
  const auto validation = [](std::vector<ValidationLine> lines) {
    return [lines](CaptureConfig* config) { config->validation = lines; };
  };
  const Case cases[] = {
      {[](auto* c) { c->grid.spacing_mm = 30.0; },
       "'grid.spacing_mm' is 30; whole steps of it do not fill a cell's side of 1 m; 29.4118 or "
       "30.303 would"},
      {[](auto* c) { c->grid.spacing_mm = 29.4118; }, "no error"},
      {[](auto* c) { c->grid.spacing_mm = 1200.0; }, "; 1000 would"},
      {validation({{LineAxis::kX, 0.0, -0.4, 0.4, 300.0}}),
       "'validation[0].spacing_mm' is 300; whole steps of it do not fill the 0.8 m from from_m to "
       "to_m; 266.667 or 400 would"},
      {[](auto* c) { c->slider.high_limit_mm = 1599.0; },
       "'slider.high_limit_mm' is 1599, which excludes station x0_032 at 1600.000 mm on the rail"},
      {[](auto* c) { c->slider.low_limit_mm = 10.0; },
       "'slider.low_limit_mm' is 10, which excludes station x0_000 at 0.000 mm on the rail"},
      {[](auto* c) {
         c->slider.high_limit_mm = 1e6;
         c->grid.overhang_mm = 0.0;
         c->grid.spacing_mm = 0.04;
       },
       "'grid.spacing_mm' is 0.04, which brings the plan to 100004 stations"},
      {[](auto* c) {
         c->grid.spacing_mm = 0.1;
         c->grid.cell_side_m = 100.0;
       },
       "'grid.spacing_mm' is 0.1, which brings"},
      {[](auto* c) {
         for (int i = 0; i < 100; ++i) {
           c->validation.push_back({LineAxis::kX, 0.01 * (i + 1) - 0.495, 0.0, 1.5, 1.0});
         }
       },
       "'validation[66].spacing_mm' is 1, which brings"},
      {validation({{LineAxis::kX, 0.0, -1000.0, 1000.0, 0.1}}),
       "to 20000133 stations; 100000 is the maximum"},
      {validation({{LineAxis::kX, 0.5, -0.4, 0.4, 100.0}}),
       "'validation[0].across_m' is 0.5, where line x1 already runs"},
      {validation({{LineAxis::kX, 0.0, -0.4, 0.4, 100.0}, {LineAxis::kX, 0.0, 0.4, 0.5, 100.0}}),
       "'validation[1].across_m' is 0, where line v0 already runs"},
      {validation({{LineAxis::kX, 0.0, -0.4, 0.4, 100.0},
                   {LineAxis::kZ, 0.0, -0.4, 0.4, 100.0},
                   {LineAxis::kX, 0.0, 0.5, 0.7, 100.0},
                   {LineAxis::kX, 0.5, 0.9, 1.2, 100.0}}),
       "no error"}};
  const CaptureConfig sound = config_;
  for (const Case& each : cases) {
    config_ = sound;
    each.change(&config_);
    EXPECT_THAT(refusal(), HasSubstr(each.message));
  }
}

TEST_F(CapturePlanTest, ALineLongerThanTheRailHasSeveralPlacements) {
  config_.grid.cells_x = 3;
  config_.grid.overhang_mm = 0.0;
  config_.slider.first_station_mm = 500.0;  // 31 stations per placement, up to 2000 mm
  config_.slider.placements_per_line = 2;
  const CapturePlan plan = this->plan();  // lines along x of 61 stations
  const std::vector<CaptureLine> parts = placements_of(plan.lines[0]);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].id, "x0");
  EXPECT_EQ(parts[0].stations.size(), 31u);
  EXPECT_EQ(parts[1].stations.size(), 30u);
  EXPECT_EQ(parts[1].stations.front().name, "x0_031");
  EXPECT_EQ(parts[1].stations.front().rail_mm, 500.0);
  EXPECT_NEAR(parts[1].stations.front().position_m.x_m, -1.5 + 31 * 0.05, 1e-12);
  EXPECT_EQ(placements_of(plan).size(), 2u * 2u + 4u);

  config_.slider.first_station_mm = 600.0;  // 29: three placements
  EXPECT_THAT(refusal(),
              HasSubstr("'slider.placements_per_line' is 2, but line x0 of 3 m needs 3"));
  config_.slider.placements_per_line = 1;
  EXPECT_THAT(refusal(), HasSubstr("slider.placements_per_line"));
  config_.slider.placements_per_line = 3;
  config_.run.mode = CaptureMode::kVideo;
  EXPECT_THAT(refusal(), HasSubstr("only a line of one placement can be recorded"));
}

using PlanJsonTest = CapturePlanTest;

TEST_F(PlanJsonTest, IsStableAndRounded) {
  config_.grid.spacing_mm = 1000.0 / 3.0;
  config_.grid.overhang_mm = 0.0;
  const std::string json = as_json();
  EXPECT_EQ(Json::parse(json)["lines"]["x0"]["stations"]["x0_001"],
            Json::parse(R"({"x_m": -0.166666667, "z_m": -0.5, "rail_mm": 333.333333})"));
  config_.grid.spacing_mm = 333.33333;
  EXPECT_EQ(as_json(), json);
  EXPECT_EQ(json.find("-0.0"), std::string::npos);
}

TEST_F(PlanJsonTest, DependsOnWhatIsCapturedAlone) {
  std::set<std::string> seen;
  const auto is_new = [&] { return seen.insert(as_json()).second; };
  EXPECT_TRUE(is_new());
  config_.slider.motion.settle_ms = 900.0;
  config_.camera.osc.url = "http://other";
  config_.run.shots = 9;
  config_.grid.k_deg = 75.9;
  EXPECT_FALSE(is_new());
  config_.grid.spacing_mm = 25.0;
  EXPECT_TRUE(is_new());
  config_.slider.first_station_mm = 1.0;
  EXPECT_TRUE(is_new());
  config_.camera.frames = FrameKind::kDualFisheye;
  EXPECT_TRUE(is_new());
  config_.camera.exposure.bracket_ev = {0.0, -2.0};
  EXPECT_TRUE(is_new());
  config_.validation = {{LineAxis::kX, 0.0, -0.4, 0.4, 100.0}};
  EXPECT_TRUE(is_new());
}

using SelectLinesTest = CapturePlanTest;

TEST_F(SelectLinesTest, TakesIdsAndRangesInTheOrderOfThePlan) {
  config_.grid.cells_z = 3;
  config_.slider.high_limit_mm = 4000.0;
  const CapturePlan plan = this->plan();  // x0 to x3, z0, z1
  const auto selected = [&](const std::vector<std::string>& words) {
    return select_lines(plan, config_.camera, words);
  };
  EXPECT_THAT(ids_of(selected({"z1", "x1-x3"})), ElementsAre("x1", "x2", "x3", "z1"));
  EXPECT_THAT(ids_of(selected({"x3-z0"})), ElementsAre("x3", "z0"));
  for (const char* wrong : {"x4", "x3-x1", "x1-", "-", ""}) {
    EXPECT_THROW(selected({wrong}), UsageError) << wrong;
  }
  EXPECT_FALSE(selected({}).part_of);
  EXPECT_FALSE(selected({"x0-z1"}).part_of);
  EXPECT_EQ(plan_json(selected({"x0-z1"}), config_.camera), plan_json(plan, config_.camera));
}

TEST_F(SelectLinesTest, APartNamesItsWholeWhateverTheRail) {
  const auto part_of = [&] {
    const CapturePlan part = select_lines(plan(), config_.camera, {"x1"});
    return Json::parse(plan_json(part, config_.camera))["part_of"];
  };
  const Json first = part_of();
  EXPECT_EQ(first["lines"], Json({"x0", "x1", "z0", "z1"}));
  config_.slider.first_station_mm = 30.0;
  EXPECT_EQ(part_of(), first);
  config_.grid.overhang_mm = 0.0;
  EXPECT_NE(part_of(), first);
}

// --- The report ----------------------------------------------------------------------------------

using PlanReportTest = CapturePlanTest;

TEST_F(PlanReportTest, CountsValidationLinesAndStationsApart) {
  config_.validation = {{LineAxis::kX, 0.0, -0.4, 0.4, 200.0}};
  config_.camera.exposure.bracket_ev = {0.0, -2.0};
  const PlanJson report = this->report();
  EXPECT_EQ(report["storage"]["pictures"], 274);
  EXPECT_THAT(plan_report_text(report), AllOf(HasSubstr("4 lines, 132 stations, 50 mm apart\n"),
                                              HasSubstr("1 line for validation, 5 stations\n")));
}

// 50 stations per side, as many as the 36,700 panoramas of 336 cells have.
TEST_F(PlanReportTest, APlanOf336CellsIsSummedUpInAFewLines) {
  set_width_px(4096);
  config_.grid = {.cell_side_m = 1.0, .cells_x = 56, .cells_z = 6, .spacing_mm = 20.0};
  config_.slider.first_station_mm = 50.0;
  config_.slider.placements_per_line = 100;
  const auto begin = std::chrono::steady_clock::now();
  const std::string text = this->text();
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(passed.count(), 1.0);
  EXPECT_THAT(text,
              AllOf(HasSubstr("64 lines, 38684 stations, 20 mm apart\n"),
                    HasSubstr("7 along x (x0 to x6): 2831 stations, 56.6 m and 29 placements "
                              "of the rail each\n"),
                    HasSubstr("57 along z (z0 to z56): 331 stations, 6.6 m and 4 placements "
                              "of the rail each\n"),
                    HasSubstr("days:      431 placements of the rail; set run.work_h_per_day"),
                    HasSubstr("cards:     not known; set camera.card_gb"),
                    HasSubstr("batteries: not known; set camera.battery_pictures")));
  EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 25);
  EXPECT_EQ(report()["grid"]["groups"][1]["placements_per_line"], 4);
}

TEST_F(PlanReportTest, TheRailIsThatOfTheLongestLine) {
  config_.grid.cells_x = 2;
  config_.grid.overhang_mm = 0.0;
  config_.slider.first_station_mm = 40.0;
  config_.slider.high_limit_mm = 2100.0;
  EXPECT_THAT(text(),
              HasSubstr("rail:      2000 mm, from 40 to 2040 mm within the limits 0 to 2100 mm\n"));
}

TEST_F(PlanReportTest, WarnsOfTooLittleOverhangAndSaysWhatItAllows) {
  EXPECT_THAT(text(), AllOf(HasSubstr("overhang:  300 mm"), HasSubstr("needs 296.2 mm"),
                            Not(HasSubstr("warning"))));
  config_.grid.overhang_mm = 201.0;  // rounded up to 250: enough for k, not for all of the blend
  EXPECT_NEAR(plan().overhang_m, 0.25, 1e-12);
  EXPECT_THAT(text(), Not(HasSubstr("warning")));
  config_.grid.overhang_mm = 100.0;
  EXPECT_NEAR(report()["overhang"]["angle_reached_deg"].get<double>(), 84.29, 0.01);
  EXPECT_THAT(text(), HasSubstr("warning: the overhang is too short for k = 76 degrees; "
                                "at worst, views near a side of the grid connect at 84.3"));
}

TEST_F(PlanReportTest, StorageFollowsThePictureSize) {
  EXPECT_THAT(text(), HasSubstr("storage:   132 pictures; set run.picture_mb"));
  set_width_px(4096);
  EXPECT_THAT(text(), HasSubstr("storage:   about 554 MB: 132 pictures of 4.2 MB"));
  config_.run.picture_mb = 12.0;
  EXPECT_THAT(text(), HasSubstr("about 1.6 GB: 132 pictures of 12 MB"));
}

// 50 mm at 2 px of 4096: 2 atan(25 mm / d) = 2 px = 3.068 mrad, so d = 16.3 m.
TEST_F(PlanReportTest, TheSpacingRuleIsThatOfTheGeometry) {
  set_width_px(4096);
  const PlanJson unknown = report();
  EXPECT_NEAR(unknown["spacing"]["nearest_resolved_m"].get<double>(),
              0.025 / std::tan(2.0 * M_PI / 4096.0), 1e-9);
  EXPECT_TRUE(unknown["spacing"]["ghost_px"].is_null());
  EXPECT_THAT(plan_report_text(unknown),
              AllOf(HasSubstr("resolves surfaces from 16.3 m on within 2 px of a panorama 4096 px"),
                    HasSubstr("set scene.nearest_m"), Not(HasSubstr("warning"))));

  config_.scene.nearest_m = 1.0;
  const PlanJson coarse = report();
  EXPECT_NEAR(coarse["spacing"]["ghost_px"].get<double>(),
              2.0 * std::atan(0.025) * 4096.0 / (2.0 * M_PI), 1e-6);
  EXPECT_NEAR(coarse["spacing"]["needed_mm"].get<double>(), 2e3 * std::tan(2.0 * M_PI / 4096.0),
              1e-6);
  EXPECT_TRUE(coarse["spacing"]["too_coarse"].get<bool>());
  EXPECT_THAT(plan_report_text(coarse), HasSubstr("warning: the spacing is too coarse"));

  config_.scene.nearest_m = 17.0;
  EXPECT_THAT(text(), Not(HasSubstr("warning")));
}

TEST_F(PlanReportTest, TimeIsReadable) {
  config_.run.picture_s = 4.0;
  EXPECT_THAT(text(), HasSubstr("pictures 9 min (4 s each), placing the rail 20 min\n"));
  config_.run.placing_s = 3600.0;
  EXPECT_THAT(text(), HasSubstr("placing the rail 4 h 00 min\n"));
  config_.run.mode = CaptureMode::kVideo;
  EXPECT_THAT(text(), HasSubstr("recorded in motion"));
}

TEST_F(PlanReportTest, DaysCardsAndChargesAreSaid) {
  set_width_px(4096);
  config_.run.work_h_per_day = 8.0;
  config_.camera.card_gb = 1.0;
  config_.camera.battery_pictures = 100;
  EXPECT_THAT(text(), AllOf(HasSubstr("days:      1 day of 8 h, 4 placements of the rail\n"),
                            HasSubstr("cards:     1 card of 1 GB for 238 pictures each"),
                            HasSubstr("batteries: 2 charges, 2 a day\n")));
}

TEST_F(PlanReportTest, LinesSayWhereTheyRunAndWhereTheRailIsPlacedAgain) {
  config_.slider.high_limit_mm = 800.0;
  config_.slider.placements_per_line = 2;
  config_.grid.overhang_mm = 200.0;
  config_.validation = {{LineAxis::kZ, 0.1, -0.4, 0.2, 200.0}};
  const PlanJson lines = report()["lines"];
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[1]["id"], "x1");
  EXPECT_NEAR(lines[1]["across_m"].get<double>(), 0.5, 1e-9);
  EXPECT_NEAR(lines[1]["from_m"].get<double>(), -0.7, 1e-9);
  EXPECT_NEAR(lines[1]["to_m"].get<double>(), 0.7, 1e-9);
  EXPECT_NEAR(lines[1]["overhang_m"].get<double>(), 0.2, 1e-9);
  ASSERT_EQ(lines[1]["placements_from_m"].size(), 2u);
  EXPECT_NEAR(lines[1]["placements_from_m"][1].get<double>(), 0.05, 1e-9);  // 29 stations: 15 + 14
  EXPECT_TRUE(lines[4]["validation"].get<bool>());
  EXPECT_EQ(lines[4]["stations"], 4);
  EXPECT_EQ(lines[4]["overhang_m"], 0.0);
}

using CaptureTimeTest = CapturePlanTest;

TEST_F(CaptureTimeTest, AddsUpSliderAndCamera) {
  config_.grid.overhang_mm = 0.0;
  config_.run.picture_s = 2.0;
  config_.run.approach_mm = 0.0;
  config_.slider.motion.settle_ms = 500.0;
  const CaptureTime time = estimate_time(plan(), config_);
  // Homing over 2000 mm; per line 20 steps of 50 mm at 1 s, and the return for three of four.
  EXPECT_NEAR(time.motion_s, 20.5 + 4 * 20.0 + 3 * 10.5, 1e-6);
  EXPECT_NEAR(time.settling_s, 4 * 22 * 0.5, 1e-9);
  EXPECT_NEAR(time.pictures_s, 84 * 2.0, 1e-9);
  EXPECT_NEAR(time.placing_s, 4 * 300.0, 1e-9);
  EXPECT_NEAR(time.total_s(), time.motion_s + 44.0 + 168.0 + 1200.0, 1e-9);
}

TEST_F(CaptureTimeTest, AVideoPassesWithoutAStop) {
  config_.grid.overhang_mm = 0.0;
  config_.run.mode = CaptureMode::kVideo;
  config_.run.video_speed_mm_s = 20.0;
  config_.run.approach_mm = 0.0;
  const CaptureTime time = estimate_time(plan(), config_);
  EXPECT_NEAR(time.motion_s, 20.5 + 4 * (50.0 + 0.1) + 3 * 10.5, 1e-6);
  EXPECT_EQ(time.pictures_s, 0.0);
}

TEST_F(CaptureTimeTest, OfAPictureFollowsTheCamera) {
  CameraConfig& camera = config_.camera;
  const double one_s = picture_s(config_);
  camera.exposure.bracket_ev = {0.0, -2.0};
  EXPECT_NEAR(picture_s(config_), 2.0 * one_s, 1e-12);
  camera.kind = CameraKind::kGpio;
  EXPECT_NEAR(picture_s(config_), 2.0 * 2.4, 1e-12);  // 300 + 100 + 2000 ms
  camera.trigger.press_per_exposure = false;
  EXPECT_NEAR(picture_s(config_), 2.4, 1e-12);
  camera.trigger.busy_line = 5;
  EXPECT_LT(picture_s(config_), 2.4);
  camera.kind = CameraKind::kV4l2;
  EXPECT_NEAR(picture_s(config_), 2.0 * 0.08, 1e-12);
  config_.run.picture_s = 4.0;
  EXPECT_NEAR(picture_s(config_), 8.0, 1e-12);
}

class FieldWorkTest : public CapturePlanTest {
 protected:
  // With 36,700 pictures of 8 MB, which take this time.
  PlanJson work(double hours) const {
    return field_work(plan(), config_, {.pictures_s = 3600.0 * hours}, 36700, 8.0);
  }
};

TEST_F(FieldWorkTest, DaysAfterTheFirstBeginWithHomingAndPlacing) {
  // Homing takes 20.5 s, both together an hour.
  config_.run.placing_s = 3579.5;
  config_.run.work_h_per_day = 5.0;
  for (const auto& [hours, days] : {std::pair{5.0, 1}, {5.1, 2}, {9.0, 2}, {9.1, 3}}) {
    EXPECT_EQ(work(hours)["days"], days) << hours;
  }
  config_.run.work_h_per_day = 1.0;  // no second day gets anywhere
  EXPECT_EQ(work(1.0)["days"], 1);
  EXPECT_TRUE(work(1.1)["days"].is_null());
}

TEST_F(FieldWorkTest, CardsAndChargesFollowFromTheSettingsOfTheCamera) {
  config_.camera.card_gb = 64.0;
  config_.camera.battery_pictures = 300;
  config_.run.work_h_per_day = 8.0;
  config_.run.battery_change_s = 60.0;
  const PlanJson work = this->work(100.0);
  EXPECT_EQ(work["pictures_per_card"], 8000);
  EXPECT_EQ(work["cards"], 5);
  EXPECT_EQ(work["battery_charges"], 123);
  EXPECT_EQ(work["battery_changes_s"], 122 * 60.0);
  EXPECT_EQ(work["days"], 13);  // 102.03 h: 8 h, then 12 days less 320.5 s each
  EXPECT_EQ(work["battery_charges_per_day"], 10);

  config_.camera.battery_min = 30.0;  // ends before 300 pictures
  EXPECT_EQ(this->work(100.0)["battery_charges"], 200);
  config_.camera.kind = CameraKind::kV4l2;
  EXPECT_TRUE(this->work(100.0)["cards"].is_null());
}

// Nothing is assumed.
TEST_F(PlanReportTest, WhatTheConfigurationDoesNotSayIsUnknown) {
  const PlanJson report = this->report();
  for (const char* key : {"days", "cards", "pictures_per_card", "battery_charges"}) {
    EXPECT_TRUE(report["work"][key].is_null()) << key;
  }
  EXPECT_TRUE(report["storage"]["picture_mb"].is_null());
  EXPECT_TRUE(report["spacing"].is_null());
  EXPECT_TRUE(report["warnings"].empty());
  EXPECT_THAT(plan_report_text(report), HasSubstr("spacing:   set camera.width_px"));
}

}  // namespace
}  // namespace raywalk::capture
