#include "capture/camera/v4l2_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/camera/fake_video_device.h"

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

CameraConfig streaming(PixelFormat pixel_format = PixelFormat::kMjpg) {
  CameraConfig config;
  config.kind = CameraKind::kV4l2;
  config.width_px = 64;
  config.height_px = 32;
  config.v4l2.pixel_format = pixel_format;
  return config;
}

struct VideoRig {
  explicit VideoRig(const FakeVideoSettings& settings = {},
                    const CameraConfig& config = streaming(), FakeScene scene = {})
      : camera(config, std::make_unique<FakeVideoDevice>(settings, &clock, scene), &clock) {}

  ManualClock clock;
  V4l2Camera camera;
};

// A scene that shows when it was exposed, in steps of 100 ms.
cv::Mat clock_face(SteadyTime exposed, int /*exposure*/, PanoramaSize size) {
  const auto steps = exposed.time_since_epoch() / milliseconds(100);
  return {size.height, size.width, CV_8UC3, cv::Scalar::all(static_cast<double>(steps))};
}

double brightness(const Picture& picture) {
  const std::vector<unsigned char> bytes(picture.bytes.begin(), picture.bytes.end());
  const cv::Mat decoded = cv::imdecode(bytes, cv::IMREAD_COLOR);
  EXPECT_EQ(decoded.size(), cv::Size(picture.size.width, picture.size.height));
  return cv::mean(decoded)[1];
}

class V4l2CameraPixels : public testing::TestWithParam<PixelFormat> {};
INSTANTIATE_TEST_SUITE_P(Formats, V4l2CameraPixels, testing::ValuesIn(kPixelFormats));

TEST_P(V4l2CameraPixels, PictureWasExposedAfterTheCarriageSettled) {
  VideoRig rig({.frames_per_second = 25}, streaming(GetParam()), clock_face);
  rig.camera.prepare({}, "");
  for (int station = 0; station < 4; ++station) {
    rig.clock.sleep(milliseconds(2300));  // the slider moves, and nobody fetches frames
    const SteadyTime settled = rig.clock.now();
    const Shot shot = rig.camera.shoot(settled);
    ASSERT_EQ(shot.pictures.size(), 1U);
    EXPECT_EQ(shot.pictures[0].extension, "jpg");
    EXPECT_EQ(shot.pictures[0].size, (PanoramaSize{64, 32}));
    const double settled_steps = static_cast<double>(settled.time_since_epoch().count()) / 1e8;
    EXPECT_GE(brightness(shot.pictures[0]) + 2.5, settled_steps);
    EXPECT_GE(shot.exposed_at, wall_time_of(rig.clock, settled) + milliseconds(40));
    // 40 ms of exposure, and the period of the first whole frame after that.
    EXPECT_LE(shot.exposing_ms, 80.0);
  }
}

// The boundary itself: with frames 40 ms apart and a station settled at any time.
TEST(V4l2Camera, NoFrameIsStampedBeforeSettlingAndExposure) {
  for (int offset_ms = 0; offset_ms < 90; offset_ms += 7) {
    VideoRig rig;
    rig.camera.prepare({}, "");
    rig.clock.sleep(milliseconds(500 + offset_ms));
    const SteadyTime settled = rig.clock.now();
    EXPECT_GE(rig.camera.shoot(settled).exposed_at,
              wall_time_of(rig.clock, settled) + milliseconds(40))
        << offset_ms;
  }
}

TEST(V4l2Camera, WaitsForALongExposure) {
  VideoRig rig;
  ExposureSettings settings;
  settings.shutter_s = 0.25;
  rig.camera.prepare(settings, "");
  const SteadyTime settled = rig.clock.now();
  EXPECT_GE(rig.camera.shoot(settled).exposed_at,
            wall_time_of(rig.clock, settled) + milliseconds(250));
}

TEST(V4l2Camera, ReportsWithoutStreaming) {
  VideoRig rig;
  const CameraReport report = rig.camera.report();
  EXPECT_EQ(report.identity, "Fake 360, driver fake 1.0.0, bus usb-fake");
  EXPECT_EQ(report.state, "can stream 64x32 MJPG");
  rig.camera.prepare({}, "");
  EXPECT_EQ(rig.camera.report().state, "streams 64x32 MJPG");
  EXPECT_EQ(rig.camera.description(), "Fake 360 at /dev/video-fake");
}

TEST(V4l2Camera, UsesTheCurrentSizeIfNoneIsConfigured) {
  CameraConfig config = streaming();
  config.width_px = config.height_px = 0;
  VideoRig rig({.width_px = 96, .height_px = 48}, config);
  EXPECT_EQ(rig.camera.shoot(rig.clock.now()).pictures.at(0).size, (PanoramaSize{96, 48}));
}

TEST(V4l2Camera, DriverThatOffersAnotherFormatIsAWrongDevice) {
  VideoRig size({.width_px = 80, .height_px = 40, .any_size = false});
  EXPECT_THAT(fault_of([&] { size.camera.report(); }).what(),
              HasSubstr("offers 80x40 MJPG instead of 64x32 MJPG; set camera.width_px"));
  const DeviceFault fault = fault_of([&] { size.camera.prepare({}, ""); });
  EXPECT_EQ(fault.kind(), FaultKind::kWrongDevice);
  VideoRig pixels({.pixels = "YUYV"});
  EXPECT_THAT(fault_of([&] { pixels.camera.report(); }).what(), HasSubstr("offers 64x32 YUYV"));
}

TEST(V4l2Camera, PanoramasAreTwiceAsWideAsHigh) {
  CameraConfig config = streaming();
  config.height_px = 40;
  VideoRig rig({}, config);
  EXPECT_THAT(fault_of([&] { rig.camera.report(); }).what(),
              HasSubstr("a panorama is twice as wide as high"));
  config.frames = FrameKind::kDualFisheye;
  VideoRig fisheye({}, config);
  EXPECT_NO_THROW(fisheye.camera.report());
}

TEST_P(V4l2CameraPixels, DamagedShortAndEmptyFramesAreSkipped) {
  VideoRig rig({.damaged_every = 2, .short_every = 3, .empty_every = 5}, streaming(GetParam()));
  rig.camera.prepare({}, "");
  for (int station = 0; station < 20; ++station) {
    rig.clock.sleep(milliseconds(330));
    const Shot shot = rig.camera.shoot(rig.clock.now());
    ASSERT_EQ(shot.pictures.size(), 1U);
    EXPECT_NEAR(brightness(shot.pictures[0]), 75.0, 2.0);  // the locked exposure
  }
}

TEST_P(V4l2CameraPixels, OnlyDamagedFramesAreABadPicture) {
  for (const auto how : {&FakeVideoSettings::damaged_every, &FakeVideoSettings::short_every,
                         &FakeVideoSettings::empty_every}) {
    FakeVideoSettings settings;
    settings.*how = 1;
    VideoRig rig(settings, streaming(GetParam()));
    const DeviceFault fault = fault_of([&] { rig.camera.shoot(rig.clock.now()); });
    EXPECT_EQ(fault.kind(), FaultKind::kBadPicture);
    EXPECT_TRUE(fault.is_retryable());
    EXPECT_THAT(fault.what(), HasSubstr("gave only damaged frames within 3000 ms ("));
  }
}

TEST(V4l2Camera, CameraThatFallsSilentIsATimeout) {
  VideoRig rig({.silent_after_frame = 80});
  rig.camera.prepare({}, "");
  SteadyTime settled;
  expect_fault(FaultKind::kTimeout, "gave no frame within 3000 ms of settling", [&] {
    for (int station = 0; station < 80; ++station) {
      rig.clock.sleep(milliseconds(300));  // frames queue and become old
      settled = rig.clock.now();
      rig.camera.shoot(settled);
    }
  });
  EXPECT_EQ(rig.clock.now(), settled + milliseconds(40 + 3000));
}

TEST(V4l2Camera, CameraWithoutFramesIsAFaultBeforeAnyMove) {
  VideoRig rig({.silent_after_frame = 1});
  EXPECT_EQ(fault_of([&] { rig.camera.prepare({}, ""); }).kind(), FaultKind::kTimeout);
}

TEST(V4l2Camera, UnpluggedCameraIsNoContact) {
  VideoRig rig({.gone_after_frame = 60});
  rig.camera.prepare({}, "");
  expect_fault(FaultKind::kNoContact, "plug it in again and resume", [&] {
    for (int station = 0; station < 60; ++station) rig.camera.shoot(rig.clock.now());
  });
}

TEST(V4l2Camera, CameraInUseElsewhereIsBusy) {
  VideoRig rig({.taken = true});
  EXPECT_EQ(fault_of([&] { rig.camera.prepare({}, ""); }).kind(), FaultKind::kBusy);
}

TEST(V4l2Camera, FramesStampedByAnotherClockAreRefused) {
  VideoRig rig({.monotonic_stamps = false});
  expect_fault(FaultKind::kWrongDevice, "uvcvideo: clock=CLOCK_MONOTONIC",
               [&] { rig.camera.shoot(rig.clock.now()); });
}

TEST(V4l2Camera, EveryPictureCarriesTheLockedExposure) {
  VideoRig rig({.sensor_exposure = 240});
  const std::string locked = rig.camera.prepare({}, "");
  const Picture picture = rig.camera.shoot(rig.clock.now()).pictures.at(0);
  EXPECT_EQ(picture.exposure, locked);
  EXPECT_NEAR(brightness(picture), 60.0, 2.0);
}

TEST(V4l2Camera, ExposureThatDriftsIsAFault) {
  VideoRig rig({.drift_after_frame = 80});
  rig.camera.prepare({}, "");
  expect_fault(FaultKind::kExposure, "has exposure_100us at 340 and not at the 300", [&] {
    for (int station = 0; station < 80; ++station) rig.camera.shoot(rig.clock.now());
  });
}

// The brightness of each picture shows that the sensor had changed before it was exposed.
TEST(V4l2Camera, BracketIsOnePictureOfEachExposure) {
  VideoRig rig({.sensor_exposure = 200, .exposure_delay_frames = 3});
  ExposureSettings settings;
  settings.bracket_ev = {-1.0, 0.0, 2.0};
  rig.camera.prepare(settings, "");
  for (int station = 0; station < 3; ++station) {
    rig.clock.sleep(milliseconds(1000));
    const Shot shot = rig.camera.shoot(rig.clock.now());
    ASSERT_EQ(shot.pictures.size(), 3U);
    EXPECT_NEAR(brightness(shot.pictures[0]), 25.0, 2.0);
    EXPECT_NEAR(brightness(shot.pictures[1]), 50.0, 2.0);
    EXPECT_NEAR(brightness(shot.pictures[2]), 200.0, 2.0);
    EXPECT_THAT(shot.pictures[2].exposure, HasSubstr("\"exposure_100us\":800"));
  }
}

TEST(V4l2Camera, YuyvOfAnyPaddingKeepsItsColours) {
  const FakeScene orange = [](SteadyTime, int, PanoramaSize size) {
    return cv::Mat(size.height, size.width, CV_8UC3, cv::Scalar(30, 120, 220));
  };
  for (const int padding : {0, 64}) {
    VideoRig rig({.line_padding_bytes = padding}, streaming(PixelFormat::kYuyv), orange);
    const Picture picture = rig.camera.shoot(rig.clock.now()).pictures.at(0);
    const std::vector<unsigned char> bytes(picture.bytes.begin(), picture.bytes.end());
    const cv::Scalar mean = cv::mean(cv::imdecode(bytes, cv::IMREAD_COLOR));
    EXPECT_NEAR(mean[0], 30.0, 4.0) << padding;
    EXPECT_NEAR(mean[1], 120.0, 4.0) << padding;
    EXPECT_NEAR(mean[2], 220.0, 4.0) << padding;
  }
}

TEST(V4l2Camera, CannotFilm) {
  VideoRig rig;
  EXPECT_THROW(rig.camera.start_film(), UsageError);
}

}  // namespace
}  // namespace raywalk::capture
