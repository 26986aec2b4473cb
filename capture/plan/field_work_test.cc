#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/plan/plan_report.h"
#include "capture/plan/test_plan.h"

namespace raywalk::capture {
namespace {

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

TEST(FieldWork, WhatTheConfigurationDoesNotSayIsUnknown) {
  const nlohmann::ordered_json work = work_of(one_cell_config(), {.pictures_s = 1.0}, 10);
  for (const char* key : {"days", "cards", "pictures_per_card", "battery_charges"}) {
    EXPECT_TRUE(work[key].is_null()) << key;
  }
}

}  // namespace
}  // namespace raywalk::capture
