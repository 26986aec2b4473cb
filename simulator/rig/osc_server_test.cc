#include "simulator/rig/osc_server.h"

#include <gtest/gtest.h>
#include <httplib.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::simulator {
namespace {

using namespace capture;

using Json = nlohmann::json;

// A grey picture whose brightness is proportional to the exposure: level 64 at gain 1.
std::string grey_picture(const ExposureNow& exposure) {
  const cv::Mat image(32, 64, CV_8UC3, cv::Scalar::all(std::min(64.0 * exposure.gain, 255.0)));
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes);
  return {bytes.begin(), bytes.end()};
}

class OscServerTest : public testing::Test {
 protected:
  OscServerTest() : camera_(settings(), &clock_, &faults_, grey_picture), client_(server_.url()) {
    client_.set_read_timeout(std::chrono::milliseconds(200));
  }

  SimulatedCameraSettings settings() const {
    SimulatedCameraSettings settings;
    settings.card_directory = directory_ / "card";
    settings.frame = {64, 32};
    return settings;
  }

  httplib::Result post(const std::string& path, const Json& body) {
    return client_.Post(path, body.dump(), "application/json");
  }

  Json execute(const std::string& name, const Json& parameters) {
    const auto reply = post("/osc/commands/execute", {{"name", name}, {"parameters", parameters}});
    return reply ? Json::parse(reply->body) : Json();
  }

  // The picture of a new trigger; empty if there is none.
  cv::Mat shoot() {
    const Json id = execute("camera.takePicture", Json::object()).value("id", Json());
    clock_.sleep(duration_from_ms(200.0));
    const Json done = Json::parse(post("/osc/commands/status", {{"id", id}})->body);
    const std::string url = done["results"].value("fileUrl", "");
    const auto file = client_.Get("/files/" + url.substr(url.rfind('/') + 1));
    if (url.empty() || !file || file->body.empty()) return {};
    const std::vector<unsigned char> bytes(file->body.begin(), file->body.end());
    return cv::imdecode(bytes, cv::IMREAD_COLOR);
  }
  static std::string echo(const std::string& body) {
    if (body.empty()) throw Error("nothing to echo");
    return body;
  }

  TestDirectory directory_;
  ManualClock clock_;
  Faults faults_{&clock_};
  SimulatedCamera camera_;
  OscServer server_{&camera_, &faults_, 0, {{"/rig/echo", echo}}};
  httplib::Client client_;
};

TEST_F(OscServerTest, RefusesAsTheApiDocuments) {
  const auto unknown = post("/osc/commands/execute", {{"name", "camera.explode"}});
  EXPECT_EQ(unknown->status, 400);
  EXPECT_EQ(Json::parse(unknown->body).at("error").at("code"), "unknownCommand");
  EXPECT_EQ(
      execute("camera.getOptions", {{"optionNames", {"iso", "_none"}}}).at("error").at("code"),
      "invalidParameterName");
  EXPECT_EQ(execute("camera.setOptions", Json::object()).at("error").at("code"),
            "missingParameter");
  EXPECT_EQ(execute("camera.setOptions", {{"options", {{"iso", "many"}}}}).at("error").at("code"),
            "invalidParameterValue");
  execute("camera.takePicture", Json::object());
  const auto busy = post("/osc/commands/execute", {{"name", "camera.takePicture"}});
  EXPECT_EQ(busy->status, 403);
  EXPECT_EQ(client_.Post("/osc/commands/execute", "no JSON", "text/plain")->status, 400);
}

TEST_F(OscServerTest, OptionsAreThoseOfTheTable) {
  const auto set = [this](const Json& options) {
    return execute("camera.setOptions", {{"options", options}});
  };
  EXPECT_EQ(set({{"exposureProgram", 1}, {"iso", 200}}).at("state"), "done");
  EXPECT_EQ(camera_.options().at("shutterSpeed"), 0.01666666) << "the metered one";
  const cv::Mat twice = shoot();
  EXPECT_EQ(set({{"iso", 100}}).at("state"), "done");
  EXPECT_NEAR(cv::mean(twice)[0], 2.0 * cv::mean(shoot())[0], 2.5);
  const Json before = camera_.options();
  for (const Json& wrong : {Json{{"iso", 101}}, Json{{"shutterSpeed", 0.0123}},
                            Json{{"_colorTemperature", 5050}}, Json{{"captureMode", "video"}}}) {
    EXPECT_EQ(set(wrong).at("error").at("code"), "invalidParameterValue") << wrong;
  }
  EXPECT_EQ(set({{"iso", 200}, {"_none", 1}}).at("error").at("code"), "invalidParameterName");
  EXPECT_EQ(camera_.options(), before) << "a refused command changes nothing";
  EXPECT_EQ(set({{"exposureProgram", 2}}).at("state"), "done");
  EXPECT_EQ(camera_.options().at("iso"), 0);
}

TEST_F(OscServerTest, NamesContinueAfterTheFilesOnTheCard) {
  shoot();
  const SimulatedCamera again(settings(), &clock_, &faults_, grey_picture);
  EXPECT_EQ(again.file("R0010001.JPG"), camera_.file("R0010001.JPG"));
  std::ofstream(directory_ / "card/R0010007.JPG") << "a picture";
  SimulatedCamera third(settings(), &clock_, &faults_, grey_picture);
  third.execute(R"({"name": "camera.takePicture"})");
  EXPECT_NO_THROW(third.file("R0010008.JPG"));
}

TEST_F(OscServerTest, PortInUseIsAnError) {
  EXPECT_THROW(OscServer(&camera_, &faults_, server_.port()), Error);
}

}  // namespace
}  // namespace raywalk::simulator
