#include "simulator/rig/simulated_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

// A grey picture whose brightness is proportional to the exposure: level 64 at gain 1.
std::string grey_picture(const ExposureNow& exposure) {
  const cv::Mat image(32, 64, CV_8UC3, cv::Scalar::all(std::min(64.0 * exposure.gain, 255.0)));
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes);
  return {bytes.begin(), bytes.end()};
}

cv::Mat decoded(const std::string& bytes) {
  const std::vector<unsigned char> buffer(bytes.begin(), bytes.end());
  return buffer.empty() ? cv::Mat() : cv::imdecode(buffer, cv::IMREAD_COLOR);
}

class SimulatedCameraTest : public testing::Test {
 protected:
  SimulatedCameraSettings settings() const {
    SimulatedCameraSettings settings;
    settings.card_directory = directory_ / "card";
    settings.exposure_ms = 200.0;
    return settings;
  }

  // The picture of a new trigger; empty if none.
  static std::string picture_of(SimulatedCamera& camera, ManualClock& clock) {
    const std::string id = camera.take_picture();
    clock.sleep(duration_from_ms(200.0));
    const std::string name = camera.progress_of(id).camera_name;
    return name.empty() ? name : camera.card().read(name);
  }

  static void expect_refused(const std::string& code, const std::function<void()>& command) {
    try {
      command();
      FAIL() << "not refused";
    } catch (const CommandRefused& refused) {
      EXPECT_EQ(refused.code(), code);
    }
  }

  TestDirectory directory_;
  ManualClock clock_;
};

TEST_F(SimulatedCameraTest, PictureIsAvailableAfterTheExposure) {
  SimulatedCamera camera(settings(), clock_, grey_picture);
  const std::string id = camera.take_picture();
  clock_.sleep(duration_from_ms(199.0));
  EXPECT_FALSE(camera.progress_of(id).done);
  EXPECT_TRUE(camera.is_exposing());
  expect_refused("disabledCommand", [&] { camera.take_picture(); });
  expect_refused("disabledCommand", [&] { camera.set_options({}); });
  clock_.sleep(duration_from_ms(1.0));
  EXPECT_TRUE(camera.progress_of(id).done);
  EXPECT_EQ(camera.progress_of(id).camera_name, "R0010001.JPG");
  EXPECT_EQ(camera.last_file(), "R0010001.JPG");
  expect_refused("invalidParameterValue", [&] { camera.progress_of("17"); });
}

TEST_F(SimulatedCameraTest, BrightnessIsProportionalToManualExposure) {
  SimulatedCamera camera(settings(), clock_, grey_picture);
  CameraOptions options;
  options.exposure_program = 1;
  options.shutter_s = 0.01666666;
  options.iso = 100;
  camera.set_options(options);
  const double once = cv::mean(decoded(picture_of(camera, clock_)))[0];
  options.iso = 200;
  camera.set_options(options);
  const double twice = cv::mean(decoded(picture_of(camera, clock_)))[0];
  EXPECT_NEAR(once, 64.0, 1.5);
  EXPECT_NEAR(twice, 128.0, 2.5);
}

TEST_F(SimulatedCameraTest, AutomaticExposureWandersAndIsNotInTheOptions) {
  SimulatedCamera camera(settings(), clock_, grey_picture);
  std::set<int> levels;
  for (int i = 0; i < 12; ++i) {
    levels.insert(cvRound(cv::mean(decoded(picture_of(camera, clock_)))[0]));
  }
  EXPECT_GE(levels.size(), 2U);
  EXPECT_EQ(camera.options().shutter_s, 0.0);
  EXPECT_EQ(camera.options().iso, 0);
}

TEST_F(SimulatedCameraTest, UnsupportedOptionsAreRefused) {
  SimulatedCamera camera(settings(), clock_, grey_picture);
  CameraOptions options;
  options.exposure_program = 1;
  options.iso = 100;
  options.shutter_s = 0.0123;
  expect_refused("invalidParameterValue", [&] { camera.set_options(options); });
  options.shutter_s = 0.01;
  options.iso = 101;
  expect_refused("invalidParameterValue", [&] { camera.set_options(options); });
  options.iso = 100;
  options.color_temperature_k = 5050;
  expect_refused("invalidParameterValue", [&] { camera.set_options(options); });
  EXPECT_EQ(camera.options().exposure_program, 2) << "a refused command changes nothing";
}

TEST_F(SimulatedCameraTest, CardFillsUp) {
  SimulatedCameraSettings small = settings();
  small.card_bytes = 5000;
  small.typical_picture_bytes = 1000;
  SimulatedCamera camera(small, clock_, grey_picture);
  int taken = 0;
  while (camera.pictures_left() > 0) {
    picture_of(camera, clock_);
    ASSERT_LE(++taken, 5);
  }
  EXPECT_GE(taken, 1);
  expect_refused("disabledCommand", [&] { camera.take_picture(); });
  camera.card().erase("R0010001.JPG");
  EXPECT_FALSE(camera.card().has("R0010001.JPG"));
}

TEST_F(SimulatedCameraTest, NamesContinueAfterTheFilesOnTheCard) {
  {
    SimulatedCamera camera(settings(), clock_, grey_picture);
    picture_of(camera, clock_);
    picture_of(camera, clock_);
  }
  SimulatedCamera camera(settings(), clock_, grey_picture);
  EXPECT_EQ(camera.card().files().size(), 2U);
  camera.take_picture();
  EXPECT_TRUE(camera.card().has("R0010003.JPG"));
}

TEST_F(SimulatedCameraTest, ScheduledFaultsOccurAtTheirPicture) {
  SimulatedCamera camera(settings(), clock_, grey_picture);
  camera.faults().schedule(CameraFault::kEmptyPicture, 2);
  camera.faults().inject(CameraFault::kTruncatedPicture);
  EXPECT_FALSE(picture_of(camera, clock_).ends_with("\xFF\xD9")) << "ends like a whole JPEG";
  EXPECT_TRUE(picture_of(camera, clock_).empty());
  EXPECT_EQ(camera.card().files()[1].bytes, 0);
  const std::string whole = picture_of(camera, clock_);
  EXPECT_TRUE(whole.ends_with("\xFF\xD9"));
  EXPECT_EQ(decoded(whole).cols, 64);
  camera.faults().inject(CameraFault::kWrongSize);
  EXPECT_EQ(decoded(picture_of(camera, clock_)).cols, 32);
  camera.faults().inject(CameraFault::kMissingPicture);
  EXPECT_TRUE(picture_of(camera, clock_).empty());
  EXPECT_EQ(camera.card().files().size(), 4U);
  EXPECT_EQ(camera.faults().occurred(), 4U);
}

TEST_F(SimulatedCameraTest, LastingFaultEndsWithItsTime) {
  SimulatedCamera camera(settings(), clock_, grey_picture);
  camera.faults().inject(CameraFault::kMissingPicture, 500.0);
  EXPECT_TRUE(picture_of(camera, clock_).empty());
  EXPECT_TRUE(picture_of(camera, clock_).empty());
  clock_.sleep(duration_from_ms(200.0));
  EXPECT_FALSE(picture_of(camera, clock_).empty());
}

TEST_F(SimulatedCameraTest, StaysBusyUntilItIsRestarted) {
  SimulatedCamera camera(settings(), clock_, grey_picture);
  camera.faults().inject(CameraFault::kBusy);
  camera.take_picture();
  clock_.sleep(std::chrono::hours(1));
  EXPECT_TRUE(camera.is_exposing());
  camera.restart();
  EXPECT_FALSE(camera.is_exposing());
  EXPECT_FALSE(picture_of(camera, clock_).empty());
}

TEST_F(SimulatedCameraTest, BusyWithADurationEndsWithAPicture) {
  SimulatedCamera camera(settings(), clock_, grey_picture);
  camera.faults().inject(CameraFault::kBusy, 5000.0);
  const std::string id = camera.take_picture();
  clock_.sleep(duration_from_ms(4900.0));
  EXPECT_FALSE(camera.progress_of(id).done);
  clock_.sleep(duration_from_ms(200.0));
  EXPECT_EQ(camera.progress_of(id).camera_name, "R0010001.JPG");
}

TEST_F(SimulatedCameraTest, FailingSourceGivesAMissingPicture) {
  SimulatedCamera camera(settings(), clock_,
                         [](const ExposureNow&) -> std::string { throw Error("no room"); });
  const std::string id = camera.take_picture();
  clock_.sleep(duration_from_ms(200.0));
  EXPECT_TRUE(camera.progress_of(id).done);
  EXPECT_EQ(camera.progress_of(id).camera_name, "");
}

TEST_F(SimulatedCameraTest, CardWithoutADirectoryIsAnError) {
  SimulatedCameraSettings bad = settings();
  bad.card_directory = "/proc/no/such/place";
  EXPECT_THROW(SimulatedCamera(bad, clock_, grey_picture), Error);
}

TEST(CameraFault, NamesRoundTrip) {
  for (const std::string& name : camera_fault_names()) {
    EXPECT_EQ(name_of(camera_fault_named(name)), name);
  }
  EXPECT_THROW(camera_fault_named("on-fire"), UsageError);
}

}  // namespace
}  // namespace raywalk::capture
