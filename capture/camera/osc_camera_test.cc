#include "capture/camera/osc_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "core/files/test_directory.h"
#include "simulator/rig/osc_server.h"

namespace raywalk::capture {
namespace {

using namespace simulator;
using testing::HasSubstr;
using Json = nlohmann::json;

// A grey picture as bright as its exposure: linear level 40 at gain 1.
std::string grey_picture(const ExposureNow& exposure, int width_px) {
  const cv::Mat image(width_px / 2, width_px, CV_8UC3,
                      cv::Scalar::all(std::min(40.0 * exposure.gain, 255.0)));
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes);
  return {bytes.begin(), bytes.end()};
}

double level_of(const Picture& picture) {
  const std::vector<unsigned char> bytes(picture.bytes.begin(), picture.bytes.end());
  return cv::mean(cv::imdecode(bytes, cv::IMREAD_COLOR))[0];
}

// The camera under test and the simulated one, connected over loopback.
class OscCameraTest : public testing::Test {
 protected:
  OscCameraTest() { start({}); }

  void start(SimulatedCameraSettings settings) {
    server_.reset();
    settings.card_directory = directory_ / "card";
    settings.exposure_ms = 300.0;
    if (settings.frame.width == 0) settings.frame = {64, 32};
    simulated_ = std::make_unique<SimulatedCamera>(settings, &clock_, &faults_,
                                                   [this](const ExposureNow& now) {
                                                     exposed_at_.push_back(clock_.now());
                                                     return grey_picture(now, width_px_);
                                                   });
    server_ = std::make_unique<OscServer>(simulated_.get(), &faults_, 0);
    config_.osc.url = server_->url();
    config_.osc.picture_timeout_ms = 20000.0;
    camera_ = std::make_unique<OscCamera>(config_, clock_);
  }

  // A camera with short timeouts, for tests of faults.
  void use_short_timeouts() {
    config_.osc.connect_timeout_ms = 300.0;
    camera_ = std::make_unique<OscCamera>(config_, clock_);
  }

  static ExposureSettings fixed(double shutter_s, std::vector<double> bracket_ev = {0.0}) {
    ExposureSettings exposure;
    exposure.shutter_s = shutter_s;
    exposure.iso = 100;
    exposure.bracket_ev = std::move(bracket_ev);
    return exposure;
  }
  static ExposureSettings unlocked(std::vector<double> bracket_ev = {0.0}) {
    ExposureSettings exposure;
    exposure.lock = false;
    exposure.bracket_ev = std::move(bracket_ev);
    return exposure;
  }
  // By another client.
  void take_picture() { simulated_->execute(R"({"name": "camera.takePicture"})"); }
  Shot shoot() { return camera_->shoot(clock_.now()); }

  TestDirectory directory_;
  ManualClock clock_;
  Faults faults_{&clock_};
  CameraConfig config_;
  int width_px_ = 64;  // of pictures
  std::vector<SteadyTime> exposed_at_;
  std::unique_ptr<SimulatedCamera> simulated_;
  std::unique_ptr<OscServer> server_;
  std::unique_ptr<OscCamera> camera_;
};

// --- Without faults --------------------------------------------------------------------------

TEST_F(OscCameraTest, FetchesThePictureThatItTookOnceTheCarriageSettled) {
  const WallTime before = clock_.wall_now();
  const Shot shot = shoot();
  ASSERT_EQ(shot.pictures.size(), 1U);
  const Picture& picture = shot.pictures[0];
  EXPECT_EQ(picture.camera_name, "R0010001.JPG");
  EXPECT_EQ(picture.extension, "jpg");
  EXPECT_EQ(picture.size, (PanoramaSize{64, 32}));
  EXPECT_EQ(picture.bytes, simulated_->file("R0010001.JPG"));
  EXPECT_GE(shot.triggered_at, before);
  EXPECT_LE(shot.triggered_at, clock_.wall_now());
  EXPECT_GE(shot.exposing_ms, 300.0);
  EXPECT_LE(shot.exposing_ms, 300.0 + 2.0 * config_.osc.poll_ms);
  const SteadyTime settled_at = clock_.now() + std::chrono::seconds(3);
  camera_->shoot(settled_at);
  EXPECT_GE(exposed_at_.at(1), settled_at);
}

TEST_F(OscCameraTest, ReportsTheStateOfTheCamera) {
  SimulatedCameraSettings settings;
  settings.battery_share = 0.25;
  settings.card_bytes = 10'000'000;
  settings.typical_picture_bytes = 1'000'000;
  start(settings);
  const CameraReport report = camera_->report();
  EXPECT_THAT(report.identity, HasSubstr("serial 00000001, firmware 1.0"));
  EXPECT_EQ(report.state, "idle");
  EXPECT_EQ(report.pictures_left, 10);
  EXPECT_EQ(report.free_bytes, 10'000'000);
  EXPECT_EQ(report.battery_share, 0.25);
  EXPECT_EQ(simulated_->pictures_taken(), 0U) << "a report changes nothing";
}

// Answers as cameras give them: Ricoh's Theta S, Z1 and X, and Insta360's, of which the last shows
// 0 of 0 bytes because it does not know; members may be missing, unknown, or of another type.
TEST(OscReport, ReportsWhatCamerasSay) {
  const std::string room =
      R"({"remainingPictures": 1200, "remainingSpace": 4900000000, "totalSpace": 7900000000})";
  struct Case {
    std::string info, state, options;
    CameraReport report;
    bool is_full = false;
  };
  for (const Case& each : std::vector<Case>{
           {R"({"manufacturer": "RICOH", "model": "RICOH THETA S", "serialNumber": "00001234",
                "firmwareVersion": "1.0.0"})",
            R"({"batteryLevel": 0.33, "_captureStatus": "idle", "_apiVersion": 2})",
            room,
            {"RICOH THETA S, serial 00001234, firmware 1.0.0", "idle", 4'900'000'000, 1200, 0.33}},
           {R"({"manufacturer": "RICOH", "model": "RICOH THETA Z1", "apiLevel": [2], "uptime": 142,
                "_wlanMacAddress": "00:00:00:00:00:00",
                "endpoints": {"httpPort": 80, "httpUpdatesPort": 80}})",
            R"({"batteryLevel": 0.8, "_batteryState": "charging", "_cameraError": [],
                "_captureStatus": "self-timer countdown", "_gpsInfo": {"lat": 65535},
                "_pluginRunning": false})",
            room,
            {"RICOH THETA Z1", "self-timer countdown", 4'900'000'000, 1200, 0.8}},
           {"{}",
            R"({"_captureStatus": "idle", "_boardTemp": 43,
                "_cameraError": ["HIGH_TEMPERATURE", "NO_MEMORY", 7]})",
            "{}",
            {"", "idle, HIGH_TEMPERATURE, NO_MEMORY"},
            true},
           {R"({"manufacturer": "Arashi Vision", "model": "Insta360 One2", "gps": false})",
            R"({"_cardState": "pass", "batteryLevel": 1})",
            R"({"totalSpace": 0, "remainingSpace": 0})",
            {"Arashi Vision Insta360 One2", "ready", {}, {}, 1.0}},
           {R"({"model": "Insta360 X3"})",
            R"({"_cardState": "noSpace"})",
            "{}",
            {"Insta360 X3", "ready, card: noSpace"},
            true},
           {R"({"model": "a\nb", "serialNumber": 12})",
            R"({"batteryLevel": "0.8", "_captureStatus": 3, "_cameraError": "none"})",
            R"({"remainingPictures": "12", "remainingSpace": 1e300})",
            {"a b", "ready"}},
           {"{}", R"({"batteryLevel": 80})", R"({"remainingPictures": -1})", {"", "ready"}},
           {"{}", "{}", R"({"remainingPictures": 0})", {"", "ready", {}, 0}, true}}) {
    SCOPED_TRACE(each.state);
    const Json state = Json::parse(each.state), options = Json::parse(each.options);
    const CameraReport report = osc_report(Json::parse(each.info), state, options);
    EXPECT_EQ(report.identity, each.report.identity);
    EXPECT_EQ(report.state, each.report.state);
    EXPECT_EQ(report.battery_share, each.report.battery_share);
    EXPECT_EQ(report.pictures_left, each.report.pictures_left);
    EXPECT_EQ(report.free_bytes, each.report.free_bytes);
    EXPECT_EQ(reports_full_card(state, options), each.is_full);
  }
}

// --- Exposure -----------------------------------------------------------------------------------

TEST_F(OscCameraTest, LocksTheMeasuredExposure) {
  const Json lock = Json::parse(camera_->prepare({}, ""));
  EXPECT_EQ(lock.at("exposureProgram"), 1);
  const double measured = lock.at("shutterSpeed").get<double>() * lock.at("iso").get<double>();
  EXPECT_NEAR(std::log2(measured * 60.0 / 100.0), 0.0, 0.5) << "what the scene asks for";
  const double first = level_of(shoot().pictures[0]);
  for (int i = 0; i < 6; ++i) {
    const Picture picture = shoot().pictures[0];
    EXPECT_NEAR(level_of(picture), first, 0.5);
    EXPECT_EQ(Json::parse(picture.exposure).at("iso"), lock.at("iso"));
  }
}

TEST_F(OscCameraTest, WithoutALockTheCameraChoosesTheExposure) {
  EXPECT_EQ(camera_->prepare(unlocked(), ""), "");
  std::set<int> levels;
  for (int i = 0; i < 8; ++i) levels.insert(cvRound(level_of(shoot().pictures[0])));
  EXPECT_GE(levels.size(), 2U);
  EXPECT_EQ(simulated_->options().at("exposureProgram"), 2);
}

TEST_F(OscCameraTest, GivenValuesAreSetWithoutMeasuring) {
  ExposureSettings exposure = fixed(1.0 / 125.0);
  exposure.iso = 210;
  exposure.white_balance_k = 3200;
  camera_->prepare(exposure, "");
  const Json options = simulated_->options();
  EXPECT_EQ(options.at("exposureProgram"), 1);
  EXPECT_EQ(options.at("shutterSpeed"), 0.008);
  EXPECT_EQ(options.at("iso"), 200);
  EXPECT_EQ(options.at("whiteBalance"), "_colorTemperature");
  EXPECT_EQ(options.at("_colorTemperature"), 3200);
  EXPECT_EQ(simulated_->pictures_taken(), 0U);
}

TEST_F(OscCameraTest, AnEarlierRunsExposureIsSetAgain) {
  const std::string first = camera_->prepare({}, "");
  const std::uint64_t taken = simulated_->pictures_taken();
  simulated_->restart();
  OscCamera again(config_, clock_);
  EXPECT_EQ(again.prepare({}, first), first);
  EXPECT_EQ(simulated_->pictures_taken(), taken) << "measured again";
  EXPECT_EQ(simulated_->options().at("exposureProgram"), 1);
  expect_fault(FaultKind::kExposure, "damaged", [&] { again.prepare({}, "{\"iso\": 100}"); });
  expect_fault(FaultKind::kExposure, "damaged", [&] { again.prepare({}, "nonsense"); });
}

TEST_F(OscCameraTest, BracketGivesEachExposureInItsOrder) {
  camera_->prepare(fixed(1.0 / 60.0, {0.0, -2.0, 1.0}), "");
  for (int station = 0; station < 2; ++station) {
    const Shot shot = shoot();
    ASSERT_EQ(shot.pictures.size(), 3U);
    EXPECT_NEAR(level_of(shot.pictures[0]), 40.0, 1.0);
    EXPECT_NEAR(level_of(shot.pictures[1]), 10.0, 1.0);
    EXPECT_NEAR(level_of(shot.pictures[2]), 80.0, 1.0);
    EXPECT_EQ(Json::parse(shot.pictures[1].exposure).at("ev"), -2.0);
    EXPECT_EQ(Json::parse(shot.pictures[2].exposure).at("shutterSpeed"), 0.03333333);
    EXPECT_GE(shot.exposing_ms, 900.0);
  }
}

TEST_F(OscCameraTest, BracketWithoutALockCompensates) {
  camera_->prepare(unlocked({-2.0, 2.0}), "");
  const Shot shot = shoot();
  ASSERT_EQ(shot.pictures.size(), 2U);
  EXPECT_GT(level_of(shot.pictures[1]), 8.0 * level_of(shot.pictures[0]));
}

TEST_F(OscCameraTest, ACameraThatLosesItsExposureIsAFault) {
  camera_->prepare(fixed(1.0 / 250.0), "");
  shoot();
  faults_.add({.kind = RigFault::kForgetsExposure});
  expect_fault(FaultKind::kExposure, "instead of", [&] { shoot(); });
}

TEST_F(OscCameraTest, AnUnsupportedSizeIsRefusedAtTheStart) {
  config_.width_px = 128;
  config_.height_px = 64;
  camera_ = std::make_unique<OscCamera>(config_, clock_);
  expect_fault(FaultKind::kWrongDevice, "64x32", [&] { camera_->prepare({}, ""); });
  EXPECT_EQ(simulated_->pictures_taken(), 0U);
}

// --- Faults -------------------------------------------------------------------------------------

TEST_F(OscCameraTest, FaultsOfAPictureAreReportedAndTheNextShotSucceeds) {
  shoot();
  for (const auto& [injected, kind, words] :
       {std::tuple{RigFault::kMissingPicture, FaultKind::kMissingPicture, "took no picture"},
        {RigFault::kTruncatedPicture, FaultKind::kBadPicture, "cut short"},
        {RigFault::kEmptyPicture, FaultKind::kBadPicture, "empty"},
        {RigFault::kWebPage, FaultKind::kBadPicture, "web page"}}) {
    faults_.add({.kind = injected});
    expect_fault(kind, words, [&] { shoot(); });
    EXPECT_EQ(shoot().pictures.size(), 1U);
  }
}

TEST_F(OscCameraTest, APictureOfAnotherSizeIsReported) {
  shoot();
  width_px_ = 32;
  expect_fault(FaultKind::kBadPicture, "32x16", [&] { shoot(); });
}

TEST_F(OscCameraTest, AFullCardIsReported) {
  SimulatedCameraSettings settings;
  settings.card_bytes = 2500;
  settings.typical_picture_bytes = 1000;
  start(settings);
  for (int i = 0; simulated_->pictures_left() > 0; ++i) {
    ASSERT_LT(i, 3);
    shoot();
  }
  expect_fault(FaultKind::kCardFull, "card is full", [&] { shoot(); });
  EXPECT_THAT(camera_->report().state, HasSubstr("NO_MEMORY"));
}

TEST_F(OscCameraTest, ACameraThatStaysBusyIsAFaultInTime) {
  faults_.add({.kind = RigFault::kBusy});
  const SteadyTime before = clock_.now();
  expect_fault(FaultKind::kBusy, "still busy after 20 s", [&] { shoot(); });
  EXPECT_LE(ms_from_duration(clock_.now() - before), 25000.0);
  expect_fault(FaultKind::kBusy, "disabledCommand", [&] { shoot(); });
  EXPECT_EQ(simulated_->pictures_taken(), 1U);
  faults_.clear();
  EXPECT_EQ(shoot().pictures.size(), 1U);
}

TEST_F(OscCameraTest, WaitsForACameraThatIsBusyForAWhile) {
  take_picture();
  EXPECT_EQ(shoot().pictures[0].camera_name, "R0010002.JPG");
  take_picture();
  EXPECT_NO_THROW(camera_->prepare({}, ""));
}

TEST_F(OscCameraTest, TriggerWhoseAnswerIsLostIsNotRepeated) {
  use_short_timeouts();
  shoot();
  faults_.add({.kind = RigFault::kSilent});
  // The first request of a shot is the trigger, because this camera needs no session.
  expect_fault(FaultKind::kMissingPicture, "answer to the trigger was lost", [&] { shoot(); });
  EXPECT_EQ(simulated_->pictures_taken(), 2U);
  EXPECT_FALSE(simulated_->is_exposing()) << "it was waited for";
  EXPECT_EQ(shoot().pictures[0].camera_name, "R0010003.JPG");
}

TEST_F(OscCameraTest, ReadsAreRepeatedAfterALostAnswer) {
  use_short_timeouts();
  for (const RigFault fault : {RigFault::kSilent, RigFault::kDown}) {
    faults_.add({.kind = fault});
    EXPECT_EQ(camera_->report().state, "idle");
  }
  faults_.add({.kind = RigFault::kSilent, .for_ms = 1e9});
  expect_fault(FaultKind::kNoContact, "no complete reply", [&] { camera_->report(); });
}

TEST_F(OscCameraTest, CameraThatIsSwitchedOffIsNoContact) {
  shoot();
  const int port = server_->port();
  server_.reset();
  expect_fault(FaultKind::kNoContact, "no connection", [&] { shoot(); });
  expect_fault(FaultKind::kNoContact, "no connection", [&] { camera_->report(); });
  server_ = std::make_unique<OscServer>(simulated_.get(), &faults_, port);
  EXPECT_EQ(shoot().pictures.size(), 1U);
}

TEST_F(OscCameraTest, AnInvalidAddressIsAUsageError) {
  for (const char* url : {"", "192.168.1.1", "https://192.168.1.1", "http://", "http://a/b"}) {
    config_.osc.url = url;
    EXPECT_THROW(OscCamera(config_, clock_), UsageError) << url;
  }
}

TEST_F(OscCameraTest, APictureLostWhileMeasuringIsTakenAgain) {
  faults_.add({.kind = RigFault::kMissingPicture});
  EXPECT_NO_THROW(camera_->prepare({}, ""));
  faults_.add({.kind = RigFault::kMissingPicture, .for_ms = 1e9});
  expect_fault(FaultKind::kMissingPicture, "took no picture", [&] { camera_->prepare({}, ""); });
}

}  // namespace
}  // namespace raywalk::capture
