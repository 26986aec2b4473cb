#include "capture/camera/osc_camera.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "capture/base/device_fault.h"
#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/camera/check_picture.h"
#include "capture/camera/osc_exposure.h"
#include "core/files/exif.h"
#include "core/files/test_support.h"
#include "simulator/rig/osc_server.h"

namespace raywalk::capture {
namespace {

using namespace simulator;
using Json = nlohmann::json;
using testing::HasSubstr;

std::string encoded(const std::string& extension, int width, int height,
                    const cv::Scalar& colour = {30, 60, 90}) {
  std::vector<unsigned char> bytes;
  cv::imencode(extension, cv::Mat(height, width, CV_8UC3, colour), bytes);
  return {bytes.begin(), bytes.end()};
}

// A grey picture as bright as its exposure: linear level 40 at gain 1.
std::string grey_picture(const ExposureNow& exposure, int width_px) {
  return encoded(".jpg", width_px, width_px / 2,
                 cv::Scalar::all(std::min(40.0 * exposure.gain, 255.0)));
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
    settings.frame = {64, 32};
    simulated_ = std::make_unique<SimulatedCamera>(settings, &clock_, &faults_,
                                                   [this](const ExposureNow& now) {
                                                     exposed_at_.push_back(clock_.now());
                                                     return grey_picture(now, width_px_);
                                                   });
    server_ = std::make_unique<OscServer>(simulated_.get(), &faults_, 0);
    config_.osc.url = server_->url();
    config_.osc.picture_timeout_ms = 20000.0;
    use_config();
  }

  // A camera with the configuration as a test has changed it.
  void use_config() { camera_ = std::make_unique<OscCamera>(config_, clock_); }

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

// --- Without faults -----------------------------------------------------------------------------

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
  start({.card_directory = {},
         .card_bytes = 10'000'000,
         .typical_picture_bytes = 1'000'000,
         .battery_share = 0.25});
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
  const Case cases[] = {
      {R"({"manufacturer": "RICOH", "model": "RICOH THETA S", "serialNumber": "00001234",
           "firmwareVersion": "1.0.0"})",
       R"({"batteryLevel": 0.33, "_captureStatus": "idle", "_apiVersion": 2})",
       room,
       {"RICOH THETA S, serial 00001234, firmware 1.0.0", "idle", 4'900'000'000, 1200, 0.33}},
      {R"({"manufacturer": "RICOH", "model": "RICOH THETA Z1", "apiLevel": [2], "uptime": 142})",
       R"({"batteryLevel": 0.8, "_cameraError": [], "_captureStatus": "self-timer countdown"})",
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
      {"{}", "{}", R"({"remainingPictures": 0})", {"", "ready", {}, 0}, true}};
  for (const Case& each : cases) {
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

TEST_F(OscCameraTest, GivenValuesAreSetWithoutMeasuring) {
  camera_->prepare({.shutter_s = 1.0 / 125.0, .iso = 210, .white_balance_k = 3200}, "");
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
  camera_->prepare({.shutter_s = 1.0 / 60.0, .iso = 100, .bracket_ev = {0.0, -2.0, 1.0}}, "");
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
  camera_->prepare({.lock = false, .bracket_ev = {-2.0, 2.0}}, "");
  const Shot shot = shoot();
  EXPECT_GT(level_of(shot.pictures.at(1)), 8.0 * level_of(shot.pictures[0]));
}

TEST_F(OscCameraTest, ACameraThatLosesItsExposureIsAFault) {
  camera_->prepare({.shutter_s = 1.0 / 250.0, .iso = 100}, "");
  shoot();
  faults_.add({.kind = RigFault::kForgetsExposure});
  expect_fault(FaultKind::kExposure, "instead of", [&] { shoot(); });
}

TEST_F(OscCameraTest, AnUnsupportedSizeIsRefusedAtTheStart) {
  config_.width_px = 128;
  config_.height_px = 64;
  use_config();
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
  expect_fault(FaultKind::kBadPicture, "is 32x16, but this session's are 64x32", [&] { shoot(); });
}

TEST_F(OscCameraTest, AFullCardIsReported) {
  start({.card_directory = {}, .card_bytes = 2500, .typical_picture_bytes = 1000});
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
  config_.osc.connect_timeout_ms = 300.0;
  use_config();
  shoot();
  faults_.add({.kind = RigFault::kSilent});
  // The first request of a shot is the trigger, because this camera needs no session.
  expect_fault(FaultKind::kMissingPicture, "answer to the trigger was lost", [&] { shoot(); });
  EXPECT_EQ(simulated_->pictures_taken(), 2U);
  EXPECT_FALSE(simulated_->is_exposing()) << "it was waited for";
  EXPECT_EQ(shoot().pictures[0].camera_name, "R0010003.JPG");
}

TEST_F(OscCameraTest, ReadsAreRepeatedAfterALostAnswer) {
  config_.osc.connect_timeout_ms = 300.0;
  use_config();
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

// The lists of a Ricoh Theta, shortened; Insta360's lists start with 0, which means automatic.
const Json kTheta = {
    {"shutterSpeedSupport", {0, 0.001, 0.002, 0.004, 0.008, 0.01666666, 0.03333333, 0.125}},
    {"isoSupport", {0, 100, 200, 400, 800, 1600}},
    {"exposureCompensationSupport", {-2.0, -1.0, -0.3, 0.0, 0.3, 1.0, 2.0}},
    {"whiteBalanceSupport", {"auto", "daylight", "_colorTemperature"}},
    {"_colorTemperature", 4300}};
const Json kAny = Json::object();

TEST(OscExposure, TakesTheSupportedValueNearestByRatio) {
  EXPECT_EQ(nearest_supported(kTheta, "shutterSpeed", 1.0 / 60.0), 0.01666666);
  EXPECT_EQ(nearest_supported(kTheta, "shutterSpeed", 1e-9), 0.001) << "never 0, automatic";
  EXPECT_EQ(nearest_supported(kTheta, "shutterSpeed", 1e9), 0.125);
  EXPECT_EQ(nearest_supported(kTheta, "iso", 290), 400) << "290 is nearer to 200 by difference";
  EXPECT_EQ(nearest_supported(kAny, "iso", 123), 123);
  EXPECT_EQ(nearest_supported({{"isoSupport", {{"minIso", 50}}}}, "iso", 123), 123);
  EXPECT_EQ(nearest_compensation(kTheta, 0.8), 1.0);
  EXPECT_EQ(nearest_compensation(kTheta, -5.0), -2.0);
  EXPECT_EQ(nearest_compensation(kAny, 0.8), 0.8);
}

TEST(OscExposure, ValuesThatAreNotGivenKeepTheMeasuredBrightness) {
  struct Case {
    double wanted_s;
    int wanted_iso;
    std::optional<ExifExposure> measured;
    const Json& options;
    ExifExposure chosen;
  };
  for (const Case& each : {Case{0.002, 0, ExifExposure{0.01, 200}, kAny, {0.002, 1000}},
                           {0.0, 100, ExifExposure{0.01, 200}, kAny, {0.02, 100}},
                           {0.5, 50, {}, kAny, {0.5, 50}},
                           {0.0, 0, ExifExposure{0.008, 100}, kTheta, {0.008, 100}},
                           // The shutter time compensates for an unsupported sensitivity.
                           {0.0, 0, ExifExposure{0.016, 50}, kTheta, {0.008, 100}}}) {
    const ExposureSettings wanted{.shutter_s = each.wanted_s, .iso = each.wanted_iso};
    const ExifExposure chosen = chosen_exposure(wanted, each.measured, each.options);
    EXPECT_NEAR(chosen.shutter_s, each.chosen.shutter_s, 1e-9);
    EXPECT_EQ(chosen.iso, each.chosen.iso);
  }
  expect_fault(FaultKind::kExposure, "camera.exposure.shutter_s",
               [] { chosen_exposure({.shutter_s = 0.002}, std::nullopt, kAny); });
}

TEST(OscExposure, LocksWhiteBalanceByTemperatureOrElseByDaylight) {
  const ExifExposure exposure{0.01, 100};
  const Json given = locking_options(exposure, 5130, kTheta);
  EXPECT_EQ(given.at("whiteBalance"), "_colorTemperature");
  EXPECT_EQ(given.at("_colorTemperature"), 5100) << "in steps of 100 K";
  EXPECT_EQ(locking_options(exposure, 0, kTheta).at("_colorTemperature"), 4300);
  const Json insta = {{"whiteBalanceSupport", {"auto", "daylight"}}};
  EXPECT_EQ(locking_options(exposure, 0, insta).at("whiteBalance"), "daylight");
  EXPECT_FALSE(locking_options(exposure, 0, insta).contains("_colorTemperature"));
  EXPECT_THROW(locking_options(exposure, 5000, insta), DeviceFault);
}

TEST(OscExposure, NamesTheFirstOptionThatIsNotHeld) {
  const Json set = {{"exposureProgram", 1}, {"iso", 100}, {"shutterSpeed", 0.01666666}};
  const auto difference = [&set](const char* name, const Json& value) {
    Json held = set;
    held[name] = value;
    return first_difference(set, held);
  };
  EXPECT_EQ(first_difference(set, set), "");
  EXPECT_EQ(difference("shutterSpeed", 1.0 / 60.0), "") << "rounded";
  EXPECT_EQ(difference("shutterSpeed", 0.02), "shutterSpeed is 0.02 instead of 0.01666666");
  EXPECT_EQ(difference("iso", 0), "iso is 0 instead of 100");
  EXPECT_EQ(difference("iso", nullptr), "iso is unknown instead of 100");
  // A picture's own tags may differ by their rounding only.
  EXPECT_EQ(first_difference(set, ExifExposure{1.0 / 60.0, 100}), "");
  EXPECT_EQ(first_difference(set, ExifExposure{1.0 / 50.0, 100}),
            "shutterSpeed is 0.02 instead of 0.01666666");
  EXPECT_EQ(first_difference(set, ExifExposure{1.0 / 60.0, 125}), "iso is 125 instead of 100");
}

// --- Exif ----------------------------------------------------------------------------------------

// The exposure time in units of 10 microseconds.
std::string jpeg_with(double shutter_s, int iso) {
  const auto time = static_cast<std::uint32_t>(std::lround(1e5 * shutter_s));
  const std::string block =
      exif_block({}, {rational_entry(EXIF_TAG_EXPOSURE_TIME, time, 100'000),
                      short_entry(EXIF_TAG_ISO_SPEED_RATINGS, static_cast<std::uint16_t>(iso))});
  return with_app1(encoded(".jpg", 32, 16), kExifIdentifier, block);
}

TEST(ExifExposure, IsReadBackFromFastToSlowAndNoneIfTheTagsAreMissing) {
  for (const double shutter_s : {1.0 / 25000.0, 1.0 / 640.0, 1.0 / 60.0, 0.125, 0.4, 1.6, 60.0}) {
    const auto exposure = exif_exposure(jpeg_with(shutter_s, 3200));
    ASSERT_TRUE(exposure);
    EXPECT_NEAR(exposure->shutter_s / shutter_s, 1.0, 0.01);
    EXPECT_EQ(exposure->iso, 3200);
  }
  for (const std::string& bytes :
       {encoded(".jpg", 32, 16), std::string(), std::string("<html></html>"), jpeg_with(0.01, 0)}) {
    EXPECT_FALSE(exif_exposure(bytes));
  }
}

TEST(CheckPicture, TellsFormatAndSizeOfAWholePicture) {
  for (const std::string extension : {"jpg", "png"}) {
    const CheckedPicture checked = check_picture(encoded("." + extension, 64, 32), {}, "camera");
    EXPECT_EQ(checked.extension, extension);
    EXPECT_EQ(checked.size, (PanoramaSize{64, 32}));
  }
}

TEST(CheckPicture, NamesWhatWasSentInstead) {
  for (const auto& [bytes, words] :
       {std::pair<std::string, const char*>{"", "camera, R0010001.JPG: the picture is empty"},
        {"<!DOCTYPE html><html></html>", "web page"},
        {"\n  <HTML>\n<body>Log in</body></HTML>", "web page"},
        {R"({"error": {"code": "disabledCommand"}})", "disabledCommand"},
        {"GIF89a......", "JPEG or PNG"},
        {encoded(".bmp", 8, 4), "JPEG or PNG"}}) {
    expect_fault(FaultKind::kBadPicture, words,
                 [&bytes = bytes] { check_picture(bytes, {}, "camera, R0010001.JPG"); });
  }
}

}  // namespace
}  // namespace raywalk::capture
