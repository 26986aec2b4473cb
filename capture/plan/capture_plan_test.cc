#include "capture/plan/capture_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
#include "core/base/test_error.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// One cell of 1 m, stations 50 mm apart, on a rail of 2 m.
CaptureConfig one_cell_config() {
  CaptureConfig config;
  config.grid.spacing_mm = 50.0;
  config.slider.high_limit_mm = 2000.0;
  return config;
}

std::string refusal(const CaptureConfig& config) {
  return error_of([&] { plan_capture(config); });
}

std::vector<std::string> ids_of(const CapturePlan& plan) {
  std::vector<std::string> ids;
  for (const CaptureLine& line : plan.lines) ids.push_back(line.id);
  return ids;
}

const CaptureLine& line_of(const CapturePlan& plan, std::string_view id) {
  return *std::ranges::find(plan.lines, id, &CaptureLine::id);
}

TEST(CapturePlan, OneCellHasFourLinesThatReachBeyondItsCorners) {
  const CapturePlan plan = plan_capture(one_cell_config());
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

TEST(CapturePlan, StationsAreNamedInOrderAndPlacedOnTheRail) {
  CaptureConfig config = one_cell_config();
  config.slider.first_station_mm = 50.0;
  const CaptureLine line = plan_capture(config).lines.front();
  EXPECT_EQ(line.stations[0].name, "x0_000");
  EXPECT_EQ(line.stations[0].rail_mm, 50.0);
  EXPECT_EQ(line.stations[32].name, "x0_032");
  EXPECT_NEAR(line.stations[32].rail_mm, 50.0 + 1600.0, 1e-9);
  config.grid.spacing_mm = 0.5;
  const std::vector<CaptureStation> many = plan_capture(config).lines.front().stations;
  EXPECT_EQ(many[0].name, "x0_0000");
  EXPECT_TRUE(std::ranges::is_sorted(many, {}, &CaptureStation::name));
}

TEST(CapturePlan, LinesAreInTheOrderOfTheGridAndCentred) {
  CaptureConfig config = one_cell_config();
  config.grid.cells_x = 2;
  config.grid.overhang_mm = 0.0;
  const CapturePlan plan = plan_capture(config);
  EXPECT_THAT(ids_of(plan), ElementsAre("x0", "x1", "z0", "z1", "z2"));
  EXPECT_EQ(line_of(plan, "x0").stations.size(), 41u);
  EXPECT_EQ(line_of(plan, "z0").stations.size(), 21u);
  EXPECT_EQ(line_of(plan, "z0").across_m, -1.0);
  EXPECT_EQ(line_of(plan, "z1").across_m, 0.0);
  EXPECT_EQ(plan.overhang_m, 0.0);
}

// Later stages rely on it: corners of cells are stations of both lines.
TEST(CapturePlan, EveryCornerIsAStationOfBothItsLines) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    CaptureConfig config = one_cell_config();
    const int steps = std::uniform_int_distribution(1, 40)(random);
    config.grid.cells_x = std::uniform_int_distribution(1, 4)(random);
    config.grid.cells_z = std::uniform_int_distribution(1, 4)(random);
    config.grid.cell_side_m = std::exp(std::uniform_real_distribution(-4.0, 4.0)(random));
    config.grid.spacing_mm = config.grid.cell_side_m * 1e3 / steps;
    config.grid.k_deg = std::uniform_real_distribution(45.0, 90.0)(random);
    config.slider.high_limit_mm = 1e9;
    const CapturePlan plan = plan_capture(config);
    EXPECT_GE(plan.overhang_m, overhang_needed_m(config.grid) * (1.0 - 1e-3));
    const double tolerance_m = 1e-9 * config.grid.cell_side_m;
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

TEST(CapturePlan, ValidationLinesComeLastAndAreMarked) {
  CaptureConfig config = one_cell_config();
  config.validation = {{LineAxis::kX, 0.1, -0.4, 0.4, 200.0},
                       {LineAxis::kZ, 0.0, -0.3, 0.3, 300.0}};
  const CapturePlan plan = plan_capture(config);
  ASSERT_EQ(plan.lines.size(), 6u);
  EXPECT_FALSE(plan.lines[3].validation);
  const CaptureLine& first = plan.lines[4];
  EXPECT_EQ(first.id, "v0");
  EXPECT_TRUE(first.validation);
  ASSERT_EQ(first.stations.size(), 5u);
  EXPECT_EQ(first.stations[0].name, "v0_000");
  EXPECT_NEAR(first.stations[4].position_m.x_m, 0.4, 1e-12);
  EXPECT_EQ(first.stations[4].position_m.z_m, 0.1);
  EXPECT_EQ(first.stations[0].rail_mm, config.slider.first_station_mm);
  EXPECT_EQ(plan.lines[5].axis, LineAxis::kZ);
}

// Each is refused with a message that has this text.
TEST(CapturePlan, ImpossiblePlansAreRefusedWithTheSettingToChange) {
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
      {validation({{LineAxis::kX, 0.0, -0.4, 0.4, 300.0}}), "'validation[0].spacing_mm' is 300"},
      {validation({{LineAxis::kX, 0.0, -0.4, 0.4, 300.0}}), "; 266.667 or 400 would"},
      {[](auto* c) { c->slider.high_limit_mm = 1599.0; },
       "'slider.high_limit_mm' is 1599, which excludes station x0_032 at 1600.000 mm on the rail"},
      {[](auto* c) { c->slider.low_limit_mm = 10.0; },
       "'slider.low_limit_mm' is 10, which excludes station x0_000 at 0.000 mm on the rail"},
      {validation({{LineAxis::kZ, 0.0, -2.0, 2.0, 500.0}}), "excludes station v0_008"},
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
  for (const Case& each : cases) {
    CaptureConfig config = one_cell_config();
    each.change(&config);
    EXPECT_THAT(refusal(config), HasSubstr(each.message));
  }
}

TEST(CapturePlan, ALineLongerThanTheRailHasSeveralPlacements) {
  CaptureConfig config = one_cell_config();
  config.grid.cells_x = 3;
  config.grid.overhang_mm = 0.0;
  config.slider.first_station_mm = 500.0;  // 31 stations per placement, up to 2000 mm
  config.slider.placements_per_line = 2;
  const CapturePlan plan = plan_capture(config);  // lines along x of 61 stations
  const std::vector<CaptureLine> parts = placements_of(plan.lines[0]);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].id, "x0");
  EXPECT_EQ(parts[0].stations.size(), 31u);
  EXPECT_EQ(parts[1].stations.size(), 30u);
  EXPECT_EQ(parts[1].stations.front().name, "x0_031");
  EXPECT_EQ(parts[1].stations.front().rail_mm, 500.0);
  EXPECT_NEAR(parts[1].stations.front().position_m.x_m, -1.5 + 31 * 0.05, 1e-12);
  EXPECT_EQ(placements_of(plan).size(), 2u * 2u + 4u);

  config.slider.first_station_mm = 600.0;  // 29: three placements
  EXPECT_THAT(refusal(config),
              HasSubstr("'slider.placements_per_line' is 2, but line x0 of 3 m needs 3"));
  config.slider.placements_per_line = 1;
  EXPECT_THAT(refusal(config), HasSubstr("slider.placements_per_line"));
  config.slider.placements_per_line = 3;
  config.run.mode = CaptureMode::kVideo;
  EXPECT_THAT(refusal(config), HasSubstr("only a line of one placement can be recorded"));
}

TEST(PlanJson, IsStableAndRounded) {
  CaptureConfig config = one_cell_config();
  config.grid.spacing_mm = 1000.0 / 3.0;
  config.grid.overhang_mm = 0.0;
  const std::string json = plan_json(plan_capture(config), config.camera);
  EXPECT_EQ(nlohmann::json::parse(json)["lines"]["x0"]["stations"]["x0_001"],
            nlohmann::json::parse(R"({"x_m": -0.166666667, "z_m": -0.5, "rail_mm": 333.333333})"));
  config.grid.spacing_mm = 333.33333;
  EXPECT_EQ(plan_json(plan_capture(config), config.camera), json);
  EXPECT_EQ(json.find("-0.0"), std::string::npos);
}

TEST(PlanJson, DependsOnWhatIsCapturedAlone) {
  const auto json = [](const std::function<void(CaptureConfig * config)>& change) {
    CaptureConfig config = one_cell_config();
    change(&config);
    return plan_json(plan_capture(config), config.camera);
  };
  const std::string original = json([](auto*) {});
  const std::set<std::string> different{
      original,
      json([](auto* c) { c->grid.spacing_mm = 25.0; }),
      json([](auto* c) { c->slider.first_station_mm = 1.0; }),
      json([](auto* c) { c->camera.frames = FrameKind::kDualFisheye; }),
      json([](auto* c) {
        c->camera.exposure.bracket_ev = {0.0, -2.0};
      }),
      json([](auto* c) {
        c->validation = {{LineAxis::kX, 0.0, -0.4, 0.4, 100.0}};
      })};
  EXPECT_EQ(different.size(), 6u);
  EXPECT_EQ(json([](auto* c) {
              c->slider.motion.settle_ms = 900.0;
              c->camera.osc.url = "http://other";
              c->run.shots = 9;
              c->grid.k_deg = 75.9;
            }),
            original);
}

TEST(SelectLines, TakesIdsAndRangesInTheOrderOfThePlan) {
  CaptureConfig config = one_cell_config();
  config.grid.cells_z = 3;
  config.slider.high_limit_mm = 4000.0;
  const CapturePlan plan = plan_capture(config);  // x0 to x3, z0, z1
  const auto selected = [&](const std::vector<std::string>& words) {
    return select_lines(plan, config.camera, words);
  };
  EXPECT_THAT(ids_of(selected({"z1", "x1-x3"})), ElementsAre("x1", "x2", "x3", "z1"));
  EXPECT_THAT(ids_of(selected({"x3-z0"})), ElementsAre("x3", "z0"));
  for (const char* wrong : {"x4", "x3-x1", "x1-", "-", ""}) {
    EXPECT_THROW(selected({wrong}), UsageError) << wrong;
  }
  EXPECT_FALSE(selected({}).part_of);
  EXPECT_FALSE(selected({"x0-z1"}).part_of);
  EXPECT_EQ(plan_json(selected({"x0-z1"}), config.camera), plan_json(plan, config.camera));
}

TEST(SelectLines, APartNamesItsWholeWhateverTheRail) {
  CaptureConfig config = one_cell_config();
  const auto part_of = [&] {
    const CapturePlan part = select_lines(plan_capture(config), config.camera, {"x1"});
    return nlohmann::json::parse(plan_json(part, config.camera))["part_of"];
  };
  const nlohmann::json first = part_of();
  EXPECT_EQ(first["lines"], nlohmann::json({"x0", "x1", "z0", "z1"}));
  config.slider.first_station_mm = 30.0;
  EXPECT_EQ(part_of(), first);
  config.grid.overhang_mm = 0.0;
  EXPECT_NE(part_of(), first);
}

// --- The report ----------------------------------------------------------------------------------

nlohmann::ordered_json report_on(const CaptureConfig& config) {
  return plan_report(plan_capture(config), config);
}
std::string text_on(const CaptureConfig& config) { return plan_report_text(report_on(config)); }

CaptureConfig config_4096() {
  CaptureConfig config = one_cell_config();
  config.camera.width_px = 4096;
  config.camera.height_px = 2048;
  return config;
}

TEST(PlanReport, CountsValidationLinesAndStationsApart) {
  CaptureConfig config = one_cell_config();
  config.validation = {{LineAxis::kX, 0.0, -0.4, 0.4, 200.0}};
  config.camera.exposure.bracket_ev = {0.0, -2.0};
  const nlohmann::ordered_json report = report_on(config);
  EXPECT_EQ(report["grid"]["lines"], 4);
  EXPECT_EQ(report["grid"]["stations"], 132);
  EXPECT_EQ(report["validation"]["lines"], 1);
  EXPECT_EQ(report["validation"]["stations"], 5);
  EXPECT_EQ(report["storage"]["pictures"], 274);
  EXPECT_THAT(plan_report_text(report), AllOf(HasSubstr("4 lines, 132 stations, 50 mm apart\n"),
                                              HasSubstr("1 line for validation, 5 stations\n")));
  EXPECT_THAT(text_on(one_cell_config()), Not(HasSubstr("validation")));
}

// 50 stations per side, as many as the 36,700 panoramas of 336 cells have.
CaptureConfig config_of_336_cells() {
  CaptureConfig config = config_4096();
  config.grid = {.cell_side_m = 1.0, .cells_x = 56, .cells_z = 6, .spacing_mm = 20.0};
  config.slider.first_station_mm = 50.0;
  config.slider.placements_per_line = 100;
  return config;
}

TEST(PlanReport, APlanOf336CellsIsSummedUpInAFewLines) {
  const auto begin = std::chrono::steady_clock::now();
  const CaptureConfig config = config_of_336_cells();
  const std::string text = text_on(config);
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
  EXPECT_EQ(report_on(config)["grid"]["groups"][1]["placements_per_line"], 4);
}

TEST(PlanReport, TheRailIsThatOfTheLongestLine) {
  CaptureConfig config = one_cell_config();
  config.grid.cells_x = 2;
  config.grid.overhang_mm = 0.0;
  config.slider.first_station_mm = 40.0;
  config.slider.high_limit_mm = 2100.0;
  EXPECT_THAT(text_on(config),
              HasSubstr("rail:      2000 mm, from 40 to 2040 mm within the limits 0 to 2100 mm\n"));
}

TEST(PlanReport, WarnsOfTooLittleOverhangAndSaysWhatItAllows) {
  CaptureConfig config = one_cell_config();
  EXPECT_THAT(text_on(config), AllOf(HasSubstr("overhang:  300 mm"), HasSubstr("needs 296.2 mm"),
                                     Not(HasSubstr("warning"))));
  config.grid.overhang_mm = 201.0;  // rounded up to 250: enough for k, not for all of the blend
  EXPECT_NEAR(plan_capture(config).overhang_m, 0.25, 1e-12);
  EXPECT_THAT(text_on(config), Not(HasSubstr("warning")));
  config.grid.overhang_mm = 100.0;
  EXPECT_NEAR(report_on(config)["overhang"]["angle_reached_deg"].get<double>(), 84.29, 0.01);
  EXPECT_THAT(text_on(config),
              HasSubstr("warning: the overhang is too short for k = 76 degrees; "
                        "at worst, views near a side of the grid connect at 84.3"));
}

TEST(PlanReport, StorageFollowsThePictureSize) {
  EXPECT_THAT(text_on(one_cell_config()), HasSubstr("storage:   132 pictures; set run.picture_mb"));
  EXPECT_NEAR(*picture_mb(config_4096()), 4.194304, 1e-9);
  EXPECT_THAT(text_on(config_4096()), HasSubstr("storage:   about 554 MB: 132 pictures of 4.2 MB"));
  CaptureConfig config = config_4096();
  config.run.picture_mb = 12.0;
  EXPECT_THAT(text_on(config), HasSubstr("about 1.6 GB: 132 pictures of 12 MB"));
}

// 50 mm at 2 px of 4096: 2 atan(25 mm / d) = 2 px = 3.068 mrad, so d = 16.3 m.
TEST(PlanReport, TheSpacingRuleIsThatOfTheGeometry) {
  const nlohmann::ordered_json unknown = report_on(config_4096());
  EXPECT_NEAR(unknown["spacing"]["nearest_resolved_m"].get<double>(),
              0.025 / std::tan(2.0 * M_PI / 4096.0), 1e-9);
  EXPECT_TRUE(unknown["spacing"]["ghost_px"].is_null());
  EXPECT_THAT(plan_report_text(unknown),
              AllOf(HasSubstr("resolves surfaces from 16.3 m on within 2 px of a panorama 4096 px"),
                    HasSubstr("set scene.nearest_m"), Not(HasSubstr("warning"))));

  CaptureConfig config = config_4096();
  config.scene.nearest_m = 1.0;
  const nlohmann::ordered_json coarse = report_on(config);
  EXPECT_NEAR(coarse["spacing"]["ghost_px"].get<double>(),
              2.0 * std::atan(0.025) * 4096.0 / (2.0 * M_PI), 1e-6);
  EXPECT_NEAR(coarse["spacing"]["needed_mm"].get<double>(), 2e3 * std::tan(2.0 * M_PI / 4096.0),
              1e-6);
  EXPECT_TRUE(coarse["spacing"]["too_coarse"].get<bool>());
  EXPECT_THAT(plan_report_text(coarse), HasSubstr("warning: the spacing is too coarse"));

  config.scene.nearest_m = 17.0;
  EXPECT_FALSE(report_on(config)["spacing"]["too_coarse"].get<bool>());
  EXPECT_THAT(text_on(config), Not(HasSubstr("warning")));
}

TEST(PlanReport, TimeIsReadable) {
  CaptureConfig config = one_cell_config();
  config.run.picture_s = 4.0;
  EXPECT_THAT(text_on(config), HasSubstr("pictures 9 min (4 s each), placing the rail 20 min\n"));
  config.run.placing_s = 3600.0;
  EXPECT_THAT(text_on(config), HasSubstr("placing the rail 4 h 00 min\n"));
  config.run.mode = CaptureMode::kVideo;
  EXPECT_THAT(text_on(config), HasSubstr("recorded in motion"));
}

TEST(PlanReport, DaysCardsAndChargesAreSaid) {
  CaptureConfig config = config_4096();
  config.run.work_h_per_day = 8.0;
  config.camera.card_gb = 1.0;
  config.camera.battery_pictures = 100;
  EXPECT_THAT(text_on(config),
              AllOf(HasSubstr("days:      1 day of 8 h, 4 placements of the rail\n"),
                    HasSubstr("cards:     1 card of 1 GB for 238 pictures each"),
                    HasSubstr("batteries: 2 charges, 2 a day\n")));
}

TEST(PlanReport, LinesSayWhereTheyRunAndWhereTheRailIsPlacedAgain) {
  CaptureConfig config = one_cell_config();
  config.slider.high_limit_mm = 800.0;
  config.slider.placements_per_line = 2;
  config.grid.overhang_mm = 200.0;
  config.validation = {{LineAxis::kZ, 0.1, -0.4, 0.2, 200.0}};
  const nlohmann::ordered_json lines = report_on(config)["lines"];
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

TEST(CaptureTime, AddsUpSliderAndCamera) {
  CaptureConfig config = one_cell_config();
  config.grid.overhang_mm = 0.0;
  config.run.picture_s = 2.0;
  config.run.approach_mm = 0.0;
  config.slider.motion.settle_ms = 500.0;
  const CaptureTime time = estimate_time(plan_capture(config), config);
  // Homing over 2000 mm; per line 20 steps of 50 mm at 1 s, and the return for three of four.
  EXPECT_NEAR(time.motion_s, 20.5 + 4 * 20.0 + 3 * 10.5, 1e-6);
  EXPECT_NEAR(time.settling_s, 4 * 22 * 0.5, 1e-9);
  EXPECT_NEAR(time.pictures_s, 84 * 2.0, 1e-9);
  EXPECT_NEAR(time.placing_s, 4 * 300.0, 1e-9);
  EXPECT_NEAR(time.total_s(), time.motion_s + 44.0 + 168.0 + 1200.0, 1e-9);
}

TEST(CaptureTime, AVideoPassesWithoutAStop) {
  CaptureConfig config = one_cell_config();
  config.grid.overhang_mm = 0.0;
  config.run.mode = CaptureMode::kVideo;
  config.run.video_speed_mm_s = 20.0;
  config.run.approach_mm = 0.0;
  const CaptureTime time = estimate_time(plan_capture(config), config);
  EXPECT_NEAR(time.motion_s, 20.5 + 4 * (50.0 + 0.1) + 3 * 10.5, 1e-6);
  EXPECT_EQ(time.pictures_s, 0.0);
}

TEST(PictureTime, FollowsTheCamera) {
  CaptureConfig config = one_cell_config();
  const double one_s = picture_s(config);
  config.camera.exposure.bracket_ev = {0.0, -2.0, 2.0};
  EXPECT_NEAR(picture_s(config), 3.0 * one_s, 1e-12);
  config.run.picture_s = 4.0;
  EXPECT_NEAR(picture_s(config), 12.0, 1e-12);

  CaptureConfig gpio = one_cell_config();
  gpio.camera.kind = CameraKind::kGpio;
  EXPECT_NEAR(picture_s(gpio), 2.4, 1e-12);  // 300 + 100 + 2000 ms
  gpio.camera.exposure.bracket_ev = {0.0, -2.0};
  EXPECT_NEAR(picture_s(gpio), 4.8, 1e-12);
  gpio.camera.trigger.press_per_exposure = false;
  EXPECT_NEAR(picture_s(gpio), 2.4, 1e-12);
  gpio.camera.trigger.busy_line = 5;
  EXPECT_LT(picture_s(gpio), 2.4);

  CaptureConfig video = one_cell_config();
  video.camera.kind = CameraKind::kV4l2;
  EXPECT_NEAR(picture_s(video), 0.08, 1e-12);
}

nlohmann::ordered_json work_of(const CaptureConfig& config, const CaptureTime& time,
                               std::size_t pictures) {
  return field_work(plan_capture(config), config, time, pictures, 8.0);
}

TEST(FieldWork, DaysAfterTheFirstBeginWithHomingAndPlacing) {
  CaptureConfig config = one_cell_config();  // homing takes 20.5 s
  config.run.placing_s = 3579.5;             // so that both take an hour
  config.run.work_h_per_day = 5.0;
  const auto days = [&](double hours) {
    return work_of(config, {.pictures_s = 3600.0 * hours}, 100)["days"];
  };
  EXPECT_EQ(days(5.0), 1);
  EXPECT_EQ(days(5.1), 2);
  EXPECT_EQ(days(9.0), 2);
  EXPECT_EQ(days(9.1), 3);
  config.run.work_h_per_day = 1.0;  // no second day gets anywhere
  EXPECT_EQ(days(1.0), 1);
  EXPECT_TRUE(days(1.1).is_null());
  config.run.work_h_per_day = 0.0;
  EXPECT_TRUE(days(1.0).is_null());
}

TEST(FieldWork, CardsAndChargesFollowFromTheSettingsOfTheCamera) {
  CaptureConfig config = one_cell_config();
  config.camera.card_gb = 64.0;
  config.camera.battery_pictures = 300;
  config.run.work_h_per_day = 8.0;
  config.run.battery_change_s = 60.0;
  const CaptureTime time{.pictures_s = 100.0 * 3600.0};
  const nlohmann::ordered_json work = work_of(config, time, 36700);
  EXPECT_EQ(work["pictures_per_card"], 8000);
  EXPECT_EQ(work["cards"], 5);
  EXPECT_EQ(work["battery_charges"], 123);
  EXPECT_EQ(work["battery_changes_s"], 122 * 60.0);
  EXPECT_EQ(work["days"], 13);  // 102.03 h: 8 h, then 12 days less 320.5 s each
  EXPECT_EQ(work["battery_charges_per_day"], 10);

  config.camera.battery_min = 30.0;  // ends before 300 pictures
  EXPECT_EQ(work_of(config, time, 36700)["battery_charges"], 200);
  config.camera.kind = CameraKind::kV4l2;
  EXPECT_TRUE(work_of(config, time, 36700)["cards"].is_null());
}

// Nothing is assumed.
TEST(PlanReport, WhatTheConfigurationDoesNotSayIsUnknown) {
  const nlohmann::ordered_json report = report_on(one_cell_config());
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
