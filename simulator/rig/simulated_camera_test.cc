#include "simulator/rig/simulated_camera.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "simulator/rig/osc_server.h"

namespace raywalk::simulator {
namespace {

using Json = nlohmann::json;

class SimulatedCameraTest : public testing::Test {
 protected:
  SimulatedCameraSettings settings() const {
    return {.card_directory = directory_ / "card", .frame = {64, 32}};
  }
  OscReply execute(const std::string& name, const Json& parameters = Json::object()) {
    return camera_.execute(Json{{"name", name}, {"parameters", parameters}}.dump());
  }
  // The error's code, or "done" and the like.
  std::string outcome(const std::string& name, const Json& parameters) {
    const Json reply = execute(name, parameters).json;
    return reply.contains("error") ? reply["error"]["code"] : reply["state"];
  }
  std::string set(const Json& options) {
    return outcome("camera.setOptions", {{"options", options}});
  }
  // The gain of a new picture.
  double shoot() {
    execute("camera.takePicture");
    clock_.sleep(capture::duration_from_ms(200.0));
    return gain_;
  }

  TestDirectory directory_;
  capture::ManualClock clock_;
  Faults faults_{&clock_};
  double gain_ = 0.0;
  SimulatedCamera camera_{settings(), &clock_, &faults_, [this](const ExposureNow& exposure) {
                            gain_ = exposure.gain;
                            return std::string("\xff\xd8\xff\xd9");
                          }};
};

TEST_F(SimulatedCameraTest, RefusesAsTheApiDocuments) {
  EXPECT_EQ(execute("camera.explode").http_status, 400);
  EXPECT_EQ(outcome("camera.explode", Json::object()), "unknownCommand");
  EXPECT_EQ(outcome("camera.getOptions", {{"optionNames", {"iso", "_none"}}}),
            "invalidParameterName");
  EXPECT_EQ(outcome("camera.setOptions", Json::object()), "missingParameter");
  EXPECT_EQ(set({{"iso", "many"}}), "invalidParameterValue");
  EXPECT_EQ(outcome("camera.takePicture", Json::object()), "inProgress");
  EXPECT_EQ(execute("camera.takePicture").http_status, 403);
  EXPECT_EQ(camera_.execute("no JSON").http_status, 400);
}

TEST_F(SimulatedCameraTest, OptionsAreThoseOfTheTable) {
  EXPECT_EQ(set({{"exposureProgram", 1}, {"iso", 200}}), "done");
  EXPECT_EQ(camera_.options().at("shutterSpeed"), 0.01666666) << "the metered one";
  EXPECT_NEAR(shoot(), 2.0, 1e-6);
  EXPECT_EQ(set({{"iso", 100}}), "done");
  EXPECT_NEAR(shoot(), 1.0, 1e-6);
  const Json before = camera_.options();
  for (const Json& wrong : {Json{{"iso", 101}}, Json{{"shutterSpeed", 0.0123}},
                            Json{{"_colorTemperature", 5050}}, Json{{"captureMode", "video"}}}) {
    EXPECT_EQ(set(wrong), "invalidParameterValue") << wrong;
  }
  EXPECT_EQ(set({{"iso", 200}, {"_none", 1}}), "invalidParameterName");
  EXPECT_EQ(camera_.options(), before) << "a refused command changes nothing";
  EXPECT_EQ(set({{"exposureProgram", 2}}), "done");
  EXPECT_EQ(camera_.options().at("iso"), 0);
}

TEST_F(SimulatedCameraTest, NamesContinueAfterTheFilesOnTheCard) {
  shoot();
  std::ofstream(directory_ / "card/R0010007.JPG") << "a picture";
  SimulatedCamera again(settings(), &clock_, &faults_, [](const auto&) { return "\xff\xd8"; });
  EXPECT_EQ(again.file("R0010001.JPG"), camera_.file("R0010001.JPG"));
  again.execute(R"({"name": "camera.takePicture"})");
  EXPECT_NO_THROW(again.file("R0010008.JPG"));
}

TEST_F(SimulatedCameraTest, ServersPortInUseIsAnError) {
  const OscServer server(&camera_, &faults_, 0);
  EXPECT_THROW(OscServer(&camera_, &faults_, server.port()), Error);
}

}  // namespace
}  // namespace raywalk::simulator
