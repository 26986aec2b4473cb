#include "capture/plan/capture_time.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "capture/plan/test_plan.h"

namespace raywalk::capture {
namespace {

TEST(MoveTime, ShortMovesNeverReachTheirSpeed) {
  EXPECT_EQ(move_s(0.0, {100.0, 200.0}), 0.0);
  EXPECT_DOUBLE_EQ(move_s(8.0, {100.0, 200.0}), 0.4);
  EXPECT_DOUBLE_EQ(move_s(50.0, {100.0, 200.0}), 1.0);   // just reaches it
  EXPECT_DOUBLE_EQ(move_s(450.0, {100.0, 200.0}), 5.0);  // and keeps it for 400 mm
}

// The formula against a motion integrated in small steps of time.
TEST(MoveTime, AgreesWithTheMotionItself) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> log_of(-1.0, 3.0);
  for (int i = 0; i < 50; ++i) {
    const double distance = std::pow(10.0, log_of(random));
    const MotionProfile profile{std::pow(10.0, log_of(random)), std::pow(10.0, log_of(random))};
    const double expected = move_s(distance, profile);
    const double dt = expected / 20000.0;
    double position = 0.0, speed = 0.0, time = 0.0;
    while (time < 2.0 * expected && position < distance) {
      const double to_stop = speed * speed / (2.0 * profile.acceleration_mm_s2);
      const bool braking = position + to_stop >= distance;
      speed = braking ? speed - profile.acceleration_mm_s2 * dt
                      : std::min(profile.speed_mm_s, speed + profile.acceleration_mm_s2 * dt);
      if (speed <= 0.0) break;
      position += speed * dt;
      time += dt;
    }
    EXPECT_NEAR(time, expected, 0.02 * expected) << distance;
    EXPECT_NEAR(position, distance, 0.01 * distance);
  }
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

}  // namespace
}  // namespace raywalk::capture
