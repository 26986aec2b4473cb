#include "capture/plan/plan_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "capture/plan/test_plan.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

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
  config.grid.overhang_mm = 250.0;  // enough for k, not for all of the blend
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
  EXPECT_THAT(text_on(config), HasSubstr("filmed in motion"));
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

TEST(CaptureTime, AFilmPassesWithoutAStop) {
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
