#include "capture/camera/v4l2_exposure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/camera/fake_video_device.h"

namespace raywalk::capture {
namespace {

using testing::HasSubstr;

struct ExposureRig {
  explicit ExposureRig(const FakeVideoSettings& settings = {})
      : device(settings, &clock), exposure(&device) {}

  std::string lock(const ExposureSettings& settings, const std::string& earlier = "") {
    return exposure.lock(settings, earlier, [this] { ++measured; });
  }

  ManualClock clock;
  FakeVideoDevice device;
  V4l2Exposure exposure;
  int measured = 0;
};

template <typename Call>
void expect_exposure_fault(const std::string& words, const Call& call) {
  expect_fault(FaultKind::kExposure, words, call);
}

TEST(V4l2Exposure, LocksWhatTheCameraMeasured) {
  ExposureRig rig({.sensor_exposure = 321});
  EXPECT_EQ(rig.lock({}), R"({"exposure_100us":321,"gain":8,"white_balance_k":4600})");
  EXPECT_EQ(rig.measured, 1);
  EXPECT_EQ(rig.device.control(VideoControl::kExposureMode), 1);
  EXPECT_EQ(rig.device.control(VideoControl::kAutoGain), 0);
  EXPECT_EQ(rig.device.control(VideoControl::kAutoWhiteBalance), 0);
}

TEST(V4l2Exposure, GivenValuesAreSetAndTheRestMeasured) {
  ExposureRig rig({.sensor_exposure = 321});
  ExposureSettings settings;
  settings.shutter_s = 0.02;
  settings.white_balance_k = 5003;  // the camera has steps of 10
  EXPECT_EQ(rig.lock(settings), R"({"exposure_100us":200,"gain":8,"white_balance_k":5000})");
}

TEST(V4l2Exposure, ResumedSessionIsSetAgainAndNotMeasured) {
  ExposureRig rig({.sensor_exposure = 999});
  const std::string earlier = R"({"exposure_100us":321,"gain":3,"white_balance_k":4700})";
  EXPECT_EQ(rig.lock({}, earlier), earlier);
  EXPECT_EQ(rig.measured, 0);
}

TEST(V4l2Exposure, ResumingWithAnotherKindOfCameraIsRefused) {
  for (const std::string earlier : {R"({"iso":100})", "nonsense", "[1]"}) {
    ExposureRig rig;
    expect_exposure_fault("not settings of a V4L2 camera; resume with the camera",
                          [&] { rig.lock({}, earlier); });
  }
}

TEST(V4l2Exposure, CameraWithoutControlsIsLeftAlone) {
  ExposureRig rig({.controls = false});
  EXPECT_EQ(rig.lock({}), "");
  EXPECT_EQ(rig.exposure.confirm(), "");
  ExposureSettings settings;
  settings.shutter_s = 0.02;
  expect_exposure_fault("has no control for exposure_100us", [&] { rig.lock(settings); });
}

TEST(V4l2Exposure, NothingIsLockedIfTheLockIsOff) {
  ExposureRig rig;
  ExposureSettings settings;
  settings.lock = false;
  EXPECT_EQ(rig.lock(settings), "");
  EXPECT_EQ(rig.device.control(VideoControl::kExposureMode), 3);
  settings.bracket_ev = {-1.0, 0.0};
  EXPECT_THROW(rig.lock(settings), UsageError);
}

TEST(V4l2Exposure, NamesUnsupportedSettings) {
  ExposureRig rig;
  ExposureSettings settings;
  settings.shutter_s = 2.0;
  expect_exposure_fault("takes exposure_100us from 1 to 5000, not 20000",
                        [&] { rig.lock(settings); });
  settings.shutter_s = 0.0;
  settings.iso = 100;
  EXPECT_THROW(rig.lock(settings), UsageError);
  for (const std::string control : {"exposure_mode", "auto_gain", "gain", "white_balance_k"}) {
    ExposureRig stubborn({.refused_control = control});
    expect_exposure_fault("refuses", [&] { stubborn.lock({}); });
  }
}

TEST(V4l2Exposure, BracketMultipliesTheExposureTime) {
  ExposureRig rig({.sensor_exposure = 200});
  ExposureSettings settings;
  settings.bracket_ev = {-2.0, 0.0, 1.5};
  rig.lock(settings);
  for (const auto& [ev, exposure] : {std::pair{-2.0, 50}, {1.5, 566}, {0.0, 200}}) {
    rig.exposure.bracket(ev);
    EXPECT_EQ(rig.device.control(VideoControl::kExposure), exposure);
    EXPECT_THAT(rig.exposure.confirm(),
                HasSubstr("\"exposure_100us\":" + std::to_string(exposure)));
  }
}

TEST(V4l2Exposure, BracketBeyondTheCameraIsRefusedAtTheStart) {
  for (const double ev : {-9.0, 5.0, 1e300}) {
    ExposureRig rig({.sensor_exposure = 200});
    ExposureSettings settings;
    settings.bracket_ev = {0.0, ev};
    expect_exposure_fault("cannot expose by", [&] { rig.lock(settings); });
  }
}

TEST(V4l2Exposure, AChangeByAnotherProgramIsAFault) {
  ExposureRig rig;
  rig.lock({});
  rig.device.set_control(VideoControl::kGain, 55);
  expect_exposure_fault("has gain at 55 and not at the 8", [&] { rig.exposure.confirm(); });
  rig.device.set_control(VideoControl::kGain, 8);
  rig.device.set_control(VideoControl::kAutoWhiteBalance, 1);
  expect_exposure_fault("has auto_white_balance at 1", [&] { rig.exposure.confirm(); });
}

}  // namespace
}  // namespace raywalk::capture
