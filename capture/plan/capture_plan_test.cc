#include "capture/plan/capture_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "capture/plan/test_plan.h"
#include "core/base/test_error.h"

namespace raywalk::capture {
namespace {

using testing::HasSubstr;

std::string refusal(const CaptureConfig& config) {
  return error_of([&] { plan_capture(config); });
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
  std::string ids;
  for (const CaptureLine& line : plan.lines) ids += line.id + " ";
  EXPECT_EQ(ids, "x0 x1 z0 z1 z2 ");
  EXPECT_EQ(line_of(plan, "x0").stations.size(), 41u);
  EXPECT_EQ(line_of(plan, "z0").stations.size(), 21u);
  EXPECT_EQ(line_of(plan, "z0").across_m, -1.0);
  EXPECT_EQ(line_of(plan, "z1").across_m, 0.0);
  EXPECT_EQ(plan.overhang_m, 0.0);
}

TEST(CapturePlan, OverhangIsRoundedUpToWholeSteps) {
  CaptureConfig config = one_cell_config();
  config.grid.overhang_mm = 101.0;
  EXPECT_NEAR(plan_capture(config).overhang_m, 0.15, 1e-12);
  config.grid.overhang_mm = 150.0;
  EXPECT_NEAR(plan_capture(config).overhang_m, 0.15, 1e-12);
}

TEST(CapturePlan, ASpacingInSixDigitsFillsTheSide) {
  CaptureConfig config = one_cell_config();
  config.grid.spacing_mm = 33.3333;
  const CaptureLine line = plan_capture(config).lines.front();
  EXPECT_NEAR(line.stations[1].rail_mm - line.stations[0].rail_mm, 1000.0 / 30.0, 1e-9);
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
  EXPECT_THAT(refusal(config), HasSubstr("only a line of one placement can be filmed"));
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

}  // namespace
}  // namespace raywalk::capture
