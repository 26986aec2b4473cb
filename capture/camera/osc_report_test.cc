#include "capture/camera/osc_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

// The example of Ricoh's documentation of /osc/state, and one of /osc/info.
const Json kThetaInfo = {{"manufacturer", "RICOH"},
                         {"model", "RICOH THETA S"},
                         {"serialNumber", "00001234"},
                         {"firmwareVersion", "1.0.0"}};
const Json kThetaState = {{"batteryLevel", 0.33}, {"_captureStatus", "idle"}, {"_apiVersion", 2}};
const Json kThetaOptions = {
    {"remainingPictures", 1200}, {"remainingSpace", 4'900'000'000}, {"totalSpace", 7'900'000'000}};

TEST(OscReport, ReportsAThetasState) {
  const CameraReport report = osc_report(kThetaInfo, kThetaState, kThetaOptions);
  EXPECT_EQ(report.identity, "RICOH THETA S, serial 00001234, firmware 1.0.0");
  EXPECT_EQ(report.state, "idle");
  EXPECT_DOUBLE_EQ(report.battery_share.value_or(0.0), 0.33);
  EXPECT_EQ(report.pictures_left, 1200);
  EXPECT_EQ(report.free_bytes, 4'900'000'000);
}

// As Insta360 documents it.
TEST(OscReport, ReportsAnInsta360sState) {
  const Json state = {{"_cardState", "noSpace"}, {"batteryLevel", 1}};
  const Json options = {{"totalSpace", 0}, {"remainingSpace", 0}};
  const CameraReport report = osc_report({{"model", "Insta360 One2"}}, state, options);
  EXPECT_EQ(report.identity, "Insta360 One2");
  EXPECT_EQ(report.state, "ready, card: noSpace");
  EXPECT_DOUBLE_EQ(report.battery_share.value_or(0.0), 1.0);
  EXPECT_FALSE(report.free_bytes) << "it does not know";
  EXPECT_FALSE(report.pictures_left);
}

TEST(OscReport, ErrorsOfTheCameraAreListed) {
  const Json state = {{"_captureStatus", "idle"},
                      {"_cameraError", {"HIGH_TEMPERATURE", "NO_MEMORY"}}};
  EXPECT_EQ(osc_report(Json::object(), state, Json::object()).state,
            "idle, HIGH_TEMPERATURE, NO_MEMORY");
}

TEST(OscReport, InvalidMembersAreLeftOut) {
  const Json state = {{"batteryLevel", 80}, {"_captureStatus", 3}, {"_cameraError", "none"}};
  const Json options = {{"remainingPictures", -1}, {"remainingSpace", 1e300}};
  const CameraReport report = osc_report({{"model", "a\nb"}}, state, options);
  EXPECT_EQ(report.identity, "a b");
  EXPECT_EQ(report.state, "ready");
  EXPECT_FALSE(report.battery_share);
  EXPECT_FALSE(report.pictures_left);
  EXPECT_FALSE(report.free_bytes);
}

TEST(OscReport, FullCardIsDetectedFromEachIndicator) {
  EXPECT_FALSE(reports_full_card(kThetaState, kThetaOptions));
  EXPECT_FALSE(reports_full_card(Json::object(), Json::object()));
  EXPECT_TRUE(reports_full_card({{"_cameraError", {"NO_MEMORY"}}}, Json::object()));
  EXPECT_TRUE(reports_full_card({{"_cardState", "noSpace"}}, Json::object()));
  EXPECT_TRUE(reports_full_card(Json::object(), {{"remainingPictures", 0}}));
}

}  // namespace
}  // namespace raywalk::capture
