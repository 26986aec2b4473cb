#include "capture/camera/osc_exposure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "capture/base/test_fault.h"
#include "core/files/exif.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

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
    ExposureSettings wanted;
    wanted.shutter_s = each.wanted_s;
    wanted.iso = each.wanted_iso;
    const ExifExposure chosen = chosen_exposure(wanted, each.measured, each.options);
    EXPECT_NEAR(chosen.shutter_s, each.chosen.shutter_s, 1e-9);
    EXPECT_EQ(chosen.iso, each.chosen.iso);
    if (!each.measured) continue;
    expect_fault(FaultKind::kExposure, "camera.exposure.shutter_s",
                 [&] { chosen_exposure(wanted, std::nullopt, each.options); });
  }
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

TEST(OscExposure, BracketsByShutterTime) {
  const Json locking = locking_options({0.008, 100}, 0, kTheta);
  EXPECT_EQ(bracketed(locking, -2.0, kTheta).at("shutterSpeed"), 0.002);
  EXPECT_EQ(bracketed(locking, 1.0, kTheta).at("shutterSpeed"), 0.01666666);
  EXPECT_EQ(bracketed(locking, 0.0, kTheta), locking);
  EXPECT_EQ(bracketed(locking, 1.0, kTheta).at("iso"), 100);
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

std::string plain_jpeg() {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", cv::Mat(16, 32, CV_8UC3, cv::Scalar(30, 60, 90)), bytes);
  return {bytes.begin(), bytes.end()};
}

// The exposure time in units of 10 microseconds.
std::string jpeg_with(double shutter_s, int iso) {
  const auto time = static_cast<std::uint32_t>(std::lround(1e5 * shutter_s));
  const std::string block =
      exif_block({}, {rational_entry(EXIF_TAG_EXPOSURE_TIME, time, 100'000),
                      short_entry(EXIF_TAG_ISO_SPEED_RATINGS, static_cast<std::uint16_t>(iso))});
  return with_app1(plain_jpeg(), kExifIdentifier, block);
}

TEST(ExifExposure, IsReadBackFromFastToSlowAndNoneIfTheTagsAreMissing) {
  for (const double shutter_s : {1.0 / 25000.0, 1.0 / 640.0, 1.0 / 60.0, 0.125, 0.4, 1.6, 60.0}) {
    const auto exposure = exif_exposure(jpeg_with(shutter_s, 3200));
    ASSERT_TRUE(exposure);
    EXPECT_NEAR(exposure->shutter_s / shutter_s, 1.0, 0.01);
    EXPECT_EQ(exposure->iso, 3200);
  }
  for (const std::string& bytes :
       {plain_jpeg(), std::string(), std::string("<html></html>"), jpeg_with(0.01, 0)}) {
    EXPECT_FALSE(exif_exposure(bytes));
  }
}

}  // namespace
}  // namespace raywalk::capture
