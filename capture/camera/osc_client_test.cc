#include "capture/camera/osc_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "capture/base/device_fault.h"
#include "capture/base/manual_clock.h"
#include "capture/camera/osc_camera.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// A camera with scripted replies that records the commands.
class ScriptedCamera {
 public:
  using Answer = std::function<Json(const Json& parameters)>;

  ScriptedCamera() : port_(server_.bind_to_any_port("127.0.0.1")) {
    server_.Get("/osc/info", [this](const auto&, auto& response) { reply(info, response); });
    server_.Post("/osc/state", [this](const auto&, auto& response) {
      reply(Json{{"fingerprint", "1"}, {"state", state}}, response);
    });
    server_.Post("/osc/commands/execute", [this](const auto& request, auto& response) {
      const Json command = Json::parse(request.body);
      const std::string name = command.at("name");
      {
        const std::lock_guard lock(mutex_);
        commands_.push_back(name);
        headers_ = request.headers;
      }
      const auto answer = answers.find(name);
      reply(answer == answers.end() ? error("unknownCommand", "No such command.")
                                    : answer->second(command.value("parameters", Json::object())),
            response);
    });
    server_.Get("/picture.jpg", [this](const auto&, auto& response) {
      response.set_content(picture, "image/jpeg");
    });
    thread_ = std::thread([this] { server_.listen_after_bind(); });
  }
  ~ScriptedCamera() {
    while (!server_.is_running()) std::this_thread::yield();
    server_.stop();
    thread_.join();
  }
  ScriptedCamera(const ScriptedCamera&) = delete;
  ScriptedCamera& operator=(const ScriptedCamera&) = delete;

  static Json error(const std::string& code, const std::string& message) {
    return {{"state", "error"}, {"error", {{"code", code}, {"message", message}}}};
  }
  static Json done(const Json& results) { return {{"state", "done"}, {"results", results}}; }

  OscConfig config() const {
    OscConfig config;
    config.url = "http://127.0.0.1:" + std::to_string(port_);
    return config;
  }
  std::vector<std::string> commands() const {
    const std::lock_guard lock(mutex_);
    return commands_;
  }
  httplib::Headers headers() const {
    const std::lock_guard lock(mutex_);
    return headers_;
  }

  Json info = {{"model", "Scripted"}, {"apiLevel", {2}}};
  Json state = Json::object();
  std::string picture;  // at /picture.jpg
  std::map<std::string, Answer> answers;

 private:
  static void reply(const Json& json, httplib::Response& response) {
    if (json.contains("error")) response.status = 400;
    response.set_content(json.is_null() ? "" : json.dump(), "application/json");
  }

  httplib::Server server_;
  int port_;
  mutable std::mutex mutex_;
  std::vector<std::string> commands_;
  httplib::Headers headers_;
  std::thread thread_;
};

// Holds a set of options and refuses requests with any other, as Ricoh and Insta360 do.
ScriptedCamera::Answer options_from(const Json& known) {
  return [known](const Json& parameters) {
    Json options = Json::object();
    for (const std::string name : parameters.at("optionNames")) {
      if (!known.contains(name)) {
        return ScriptedCamera::error("invalidParameterName", "parameter is not supported.");
      }
      options[name] = known.at(name);
    }
    return ScriptedCamera::done({{"options", options}});
  };
}

class OscClientTest : public testing::Test {
 protected:
  ManualClock clock_;
  ScriptedCamera camera_;
};

TEST_F(OscClientTest, UnknownOptionsAreLeftOutAndNotRequestedAgain) {
  camera_.answers["camera.getOptions"] = options_from({{"iso", 100}, {"shutterSpeed", 0.5}});
  OscClient client(camera_.config(), clock_);
  const Json expected = {{"iso", 100}, {"shutterSpeed", 0.5}};
  EXPECT_EQ(client.options({"iso", "remainingPictures", "shutterSpeed"}), expected);
  const std::size_t requests = camera_.commands().size();
  EXPECT_EQ(client.options({"iso", "remainingPictures", "shutterSpeed"}), expected);
  EXPECT_EQ(camera_.commands().size(), requests + 1);
  EXPECT_EQ(client.options({"remainingPictures"}), Json::object());
}

TEST_F(OscClientTest, AnEmptyAnswerIsAskedForAgainExceptOfATrigger) {
  int asked = 0;
  camera_.answers["camera.getOptions"] = [&](const Json& parameters) {
    return ++asked == 1 ? Json() : options_from({{"iso", 100}})(parameters);
  };
  camera_.answers["camera.takePicture"] = [](const Json&) { return Json(); };
  OscClient client(camera_.config(), clock_);
  EXPECT_EQ(client.options({"iso"}), (Json{{"iso", 100}}));
  try {
    client.begin_picture();
    FAIL();
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kNoContact);
    EXPECT_THAT(fault.what(), HasSubstr("/osc/commands/execute: the camera answers with nothing"));
  }
  EXPECT_THAT(camera_.commands(),
              ElementsAre("camera.getOptions", "camera.getOptions", "camera.takePicture"));
}

// In standby, a Theta and an Insta360 refuse pictures until they are told their mode again.
TEST_F(OscClientTest, ACameraInStandbyIsWokenAndAskedForPanoramas) {
  std::vector<Json> set;
  camera_.answers["camera.getOptions"] =
      options_from({{"captureMode", "image"},
                    {"photoStitching", "none"},
                    {"photoStitchingSupport", {"none", "ondevice"}}});
  camera_.answers["camera.setOptions"] = [&](const Json& parameters) {
    set.push_back(parameters.at("options"));
    return ScriptedCamera::done(Json::object());
  };
  camera_.answers["camera.takePicture"] = [&](const Json&) {
    if (set.back() != Json{{"captureMode", "image"}}) {
      return ScriptedCamera::error("disabledCommand", "in standby");
    }
    return ScriptedCamera::done({{"fileUrl", "/picture.jpg"}});
  };
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", cv::Mat(32, 64, CV_8UC3, cv::Scalar::all(90)), bytes);
  camera_.picture.assign(bytes.begin(), bytes.end());
  CameraConfig config;
  config.osc = camera_.config();
  OscCamera camera(config, clock_);
  ExposureSettings automatic;
  automatic.lock = false;
  camera.prepare(automatic, "");
  EXPECT_EQ(camera.shoot(clock_.now()).pictures.size(), 1U);
  EXPECT_THAT(set,
              ElementsAre(Json{{"photoStitching", "ondevice"}}, Json{{"captureMode", "image"}}));
}

TEST_F(OscClientTest, SendsTheHeaderThatTheApiRequires) {
  camera_.answers["camera.getOptions"] = options_from({{"iso", 100}});
  OscClient client(camera_.config(), clock_);
  client.options({"iso"});
  const httplib::Headers headers = camera_.headers();
  EXPECT_EQ(headers.find("X-XSRF-Protected")->second, "1");
  EXPECT_EQ(headers.find("Content-Type")->second, "application/json;charset=utf-8");
}

TEST_F(OscClientTest, CameraOfLevel2NeedsNoSession) {
  camera_.answers["camera.getOptions"] = options_from({{"iso", 100}});
  OscClient client(camera_.config(), clock_);
  client.open_session();
  client.options({"iso"});
  EXPECT_THAT(camera_.commands(), ElementsAre("camera.getOptions"));
}

// A Ricoh Theta S has both levels and starts with the first.
TEST_F(OscClientTest, CameraOfBothLevelsIsSwitchedToTheSecondOnce) {
  camera_.info["apiLevel"] = {1, 2};
  camera_.state["_apiVersion"] = 1;
  Json raised;
  camera_.answers["camera.startSession"] = [](const Json&) {
    return ScriptedCamera::done({{"sessionId", "SID_0001"}, {"timeout", 180}});
  };
  camera_.answers["camera.setOptions"] = [&](const Json& parameters) {
    raised = parameters;
    return Json{{"name", "camera.setOptions"}, {"state", "done"}};
  };
  Json asked;
  camera_.answers["camera.getOptions"] = [&](const Json& parameters) {
    asked = parameters;
    return ScriptedCamera::done({{"options", {{"iso", 100}}}});
  };
  OscClient client(camera_.config(), clock_);
  client.open_session();
  client.open_session();
  client.options({"iso"});
  EXPECT_THAT(camera_.commands(),
              ElementsAre("camera.startSession", "camera.setOptions", "camera.getOptions"));
  EXPECT_EQ(raised, (Json{{"sessionId", "SID_0001"}, {"options", {{"clientVersion", 2}}}}));
  EXPECT_FALSE(asked.contains("sessionId"));
}

TEST_F(OscClientTest, CameraOfLevel1IsUsedWithinASession) {
  camera_.info.erase("apiLevel");
  int sessions = 0;
  camera_.answers["camera.startSession"] = [&](const Json&) {
    return Json{{"results", {{"sessionId", "S" + std::to_string(++sessions)}, {"timeout", 60}}}};
  };
  camera_.answers["camera.setOptions"] = [](const Json&) {
    return ScriptedCamera::error("invalidParameterName", "clientVersion");
  };
  camera_.answers["camera.takePicture"] = [](const Json& parameters) {
    return Json{{"results", {{"fileUri", parameters.at("sessionId").get<std::string>() + ".JPG"}}}};
  };
  Json fetched;
  camera_.answers["camera.getImage"] = [&](const Json& parameters) {
    fetched = parameters;
    return Json{{"the", "picture"}};
  };
  OscClient client(camera_.config(), clock_);
  client.open_session();
  client.open_session();
  const OscCommand command = client.begin_picture();
  EXPECT_TRUE(command.done);
  EXPECT_EQ(command.file, "S2.JPG");
  EXPECT_EQ(client.fetch("S2.JPG"), "{\"the\":\"picture\"}");
  EXPECT_EQ(fetched, (Json{{"fileUri", "S2.JPG"}}));
}

TEST_F(OscClientTest, CameraInUseByAnotherProgramIsBusy) {
  camera_.info.erase("apiLevel");
  camera_.answers["camera.startSession"] = [](const Json&) {
    return ScriptedCamera::error("cameraInExclusiveUse", "Camera already in exclusive use.");
  };
  OscClient client(camera_.config(), clock_);
  try {
    client.open_session();
    FAIL();
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kBusy);
    EXPECT_THAT(fault.what(), HasSubstr("cameraInExclusiveUse"));
  }
}

// Insta360's errors have no state.
TEST_F(OscClientTest, RefusalsCarryCodeAndMessage) {
  camera_.answers["camera.setOptions"] = [](const Json&) {
    return Json{{"error", {{"code", "invalidParameterName"}, {"message", "unsupported\noption"}}}};
  };
  camera_.answers["camera.takePicture"] = [](const Json&) {
    return ScriptedCamera::error("disabledCommand", "not in image mode");
  };
  OscClient client(camera_.config(), clock_);
  try {
    client.set_options({{"iso", 100}});
    FAIL();
  } catch (const OscRefusal& refusal) {
    EXPECT_EQ(refusal.code(), "invalidParameterName");
    EXPECT_STREQ(refusal.what(), "unsupported option");
    EXPECT_FALSE(refusal.is_temporary());
  }
  try {
    client.begin_picture();
    FAIL();
  } catch (const OscRefusal& refusal) {
    EXPECT_TRUE(refusal.is_temporary());
  }
}

TEST_F(OscClientTest, IncompleteRepliesAreAWrongDevice) {
  OscClient client(camera_.config(), clock_);
  const auto refused = [&](const Json& answer) {
    camera_.answers["camera.takePicture"] = [answer](const Json&) { return answer; };
    try {
      client.begin_picture();
    } catch (const DeviceFault& fault) {
      EXPECT_EQ(fault.kind(), FaultKind::kWrongDevice);
      EXPECT_THAT(fault.what(), Not(HasSubstr("\n")));
      return std::string(fault.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refused({{"name", "camera.takePicture"}}), HasSubstr("neither done nor in progress"));
  EXPECT_THAT(refused({{"state", "inProgress"}}), HasSubstr("without an id"));
  EXPECT_THAT(refused({{"state", 7}}), HasSubstr("neither done nor in progress"));
  EXPECT_THAT(refused(Json::object()), HasSubstr("neither done nor in progress"));
  camera_.state = "fine";
  EXPECT_THROW(client.state(), DeviceFault);
}

TEST_F(OscClientTest, DoneWithoutUsableResultsNamesNoFile) {
  OscClient client(camera_.config(), clock_);
  const auto file_of = [&](const Json& results) {
    camera_.answers["camera.takePicture"] = [results](const Json&) {
      return ScriptedCamera::done(results);
    };
    return client.begin_picture().file;
  };
  EXPECT_EQ(file_of(Json::object()), "");
  EXPECT_EQ(file_of({{"fileUrl", ""}}), "");
  EXPECT_EQ(file_of({{"fileUrl", nullptr}}), "");
  EXPECT_EQ(file_of({{"fileUrl", "http://a/b.JPG"}}), "http://a/b.JPG");
}

}  // namespace
}  // namespace raywalk::capture
