#include "capture/camera/osc_client.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <thread>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/camera/osc_camera.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using Json = nlohmann::json;
using testing::ElementsAre;

// --- HTTP ----------------------------------------------------------------------------------------

// A TCP server that runs the test's script on each connection after a request.
class RawServer {
 public:
  using Act = std::function<void(int socket, const std::atomic<bool>& ending)>;

  explicit RawServer(Act act) : act_(std::move(act)), socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        listen(socket_, 8) != 0 ||
        getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no loopback");
    }
    config_.url = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    config_.connect_timeout_ms = 200.0;
    config_.picture_timeout_ms = 500.0;
    thread_ = std::thread([this] { serve(); });
  }
  ~RawServer() {
    ending_ = true;
    thread_.join();
    close(socket_);
  }
  RawServer(const RawServer&) = delete;
  RawServer& operator=(const RawServer&) = delete;

  const OscConfig& config() const { return config_; }

 private:
  static bool readable(int socket) {
    pollfd entry{socket, POLLIN, 0};
    return poll(&entry, 1, 10) > 0;
  }

  void serve() {
    while (!ending_) {
      if (!readable(socket_)) continue;
      const int client = accept(socket_, nullptr, nullptr);
      while (!ending_ && !readable(client)) {
      }
      std::array<char, 4096> request{};
      if (recv(client, request.data(), request.size(), 0) > 0) act_(client, ending_);
      close(client);
    }
  }

  Act act_;
  int socket_;
  OscConfig config_;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

bool send_text(int socket, const std::string& text) {
  return send(socket, text.data(), text.size(), MSG_NOSIGNAL) > 0;
}

RawServer::Act says(const std::string& text) {
  return [text](int socket, const std::atomic<bool>&) { send_text(socket, text); };
}

RawServer::Act http(const std::string& status, const std::string& body) {
  return says("HTTP/1.1 " + status + "\r\nContent-Length: " + std::to_string(body.size()) +
              "\r\nConnection: close\r\n\r\n" + body);
}

// Sends `head`, and then `part` again and again, at intervals.
RawServer::Act endless(const std::string& head, const std::string& part, milliseconds interval) {
  return [=](int socket, const std::atomic<bool>& ending) {
    send_text(socket, head);
    while (!ending && (part.empty() || send_text(socket, part))) {
      std::this_thread::sleep_for(interval);
    }
  };
}

TEST(OscHttp, ServersThatAreNoCameraAreNamed) {
  struct Case {
    FaultKind kind;
    std::string words;
    RawServer::Act act;
  };
  constexpr FaultKind kWrong = FaultKind::kWrongDevice;
  constexpr FaultKind kNone = FaultKind::kNoContact;
  const std::string ok = "HTTP/1.1 200 OK\r\n";
  for (const Case& each : std::vector<Case>{
           {kWrong, "no JSON object but '<html>\\nLog in</html>'",
            http("200 OK", "<html>\nLog in</html>")},
           {kWrong, "no JSON object", http("200 OK", "{\"model\": \"The")},
           {kWrong, "no JSON object", http("200 OK", "[1, 2]")},
           {kNone, "answers with nothing", http("200 OK", "")},
           {kWrong, "neither manufacturer nor model", http("200 OK", "{\"uptime\": 7}")},
           {kWrong, "HTTP 404", http("404 Not Found", "<h1>?</h1>")},
           {kNone, "HTTP 500", http("500 Oops", "<h1>!</h1>")},
           {kNone, "no complete reply", says("")},
           {kNone, "no complete reply", says("\x01\x02\x03 garbage\r\n\r\n")},
           {kNone, "no complete reply", says(ok + "Content-")},
           {kNone, "no complete reply", says(ok + "Content-Length: 100\r\n\r\n{\"model\": \"T\"}")},
           {kWrong, "longer than",
            endless(ok + "\r\n", std::string(1 << 16, ' '), milliseconds(0))},
           {kNone, "within 200 ms", endless("", "", milliseconds(5))},
           // Each byte arrives within the timeout of a read; the whole reply never ends.
           {kNone, "within 400 ms", endless(ok + "X: ", "y", milliseconds(20))}}) {
    SCOPED_TRACE(each.words);
    RawServer server(each.act);
    ManualClock clock;
    OscClient client(server.config(), clock);
    expect_fault(each.kind, server.config().url + "/osc/info: ", [&] { client.info(); });
    expect_fault(each.kind, each.words, [&] { client.info(); });
  }
}

TEST(OscHttp, PicturesAreFetchedWholeOrNotAtAll) {
  const auto fetched = [](const std::string& file, RawServer::Act act) {
    RawServer server(std::move(act));
    ManualClock clock;
    return OscClient(server.config(), clock).fetch(file);
  };
  // The address in the reply may differ from the configured one.
  for (const char* file : {"http://192.0.2.1:80/files/R0010001.JPG", "files/R0010001.JPG"}) {
    EXPECT_EQ(fetched(file, http("200 OK", "bytes")), "bytes");
  }
  expect_fault(FaultKind::kBadPicture, "/files/R0010001.JPG: HTTP 404",
               [&] { fetched("/files/R0010001.JPG", http("404 Not Found", "no")); });
  expect_fault(FaultKind::kNoContact, "no complete reply", [&] {
    fetched("/files/R0010001.JPG", says("HTTP/1.1 200 OK\r\nContent-Length: 1000\r\n\r\nonly"));
  });
}

// The interrupt flag is never cleared, so this runs in a separate process.
TEST(OscHttpDeathTest, InterruptEndsADownload) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto interrupted_download = [] {
    install_interrupt_handlers();
    RawServer server([](int socket, const std::atomic<bool>& ending) {
      std::raise(SIGTERM);
      endless("HTTP/1.1 200 OK\r\nContent-Length: 100000000\r\n\r\n", "y", milliseconds(5))(socket,
                                                                                            ending);
    });
    ManualClock clock;
    OscConfig config = server.config();
    config.picture_timeout_ms = 60000.0;
    OscClient client(config, clock);
    try {
      client.fetch("/files/R0010001.JPG");
    } catch (const Interrupted&) {
      std::_Exit(42);
    }
    std::_Exit(1);
  };
  EXPECT_EXIT(interrupted_download(), testing::ExitedWithCode(42), "");
}

// --- The API -------------------------------------------------------------------------------------

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
    server_.Post("/osc/commands/status", [this](const auto& request, auto& response) {
      reply(answers.at("status")(Json::parse(request.body)), response);
    });
    server_.Get(".*\\.jpg", [this](const auto&, auto& response) {
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
  std::string picture;                    // at any path that ends in .jpg
  std::map<std::string, Answer> answers;  // by the command; and "status"

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
        return ScriptedCamera::error("invalidParameterName ", "parameter is not supported.");
      }
      options[name] = known.at(name);
    }
    return ScriptedCamera::done({{"options", options}});
  };
}

class OscClientTest : public testing::Test {
 protected:
  void answer(const std::string& command, const Json& with) {
    camera_.answers[command] = [with](const Json&) { return with; };
  }
  // The refusal of a call: "code: message", and whether it is temporary.
  static std::pair<std::string, bool> refusal_of(const std::function<void()>& call) {
    try {
      call();
    } catch (const OscRefusal& refusal) {
      return {refusal.code() + ": " + refusal.what(), refusal.is_temporary()};
    }
    return {"accepted", false};
  }

  ManualClock clock_;
  ScriptedCamera camera_;
  OscClient client_{camera_.config(), clock_};
};

TEST_F(OscClientTest, UnknownOptionsAreLeftOutAndNotRequestedAgain) {
  camera_.answers["camera.getOptions"] = options_from({{"iso", 100}, {"shutterSpeed", 0.5}});
  const Json expected = {{"iso", 100}, {"shutterSpeed", 0.5}};
  EXPECT_EQ(client_.options({"iso", "remainingPictures", "shutterSpeed"}), expected);
  const std::size_t requests = camera_.commands().size();
  EXPECT_EQ(client_.options({"iso", "remainingPictures", "shutterSpeed"}), expected);
  EXPECT_EQ(camera_.commands().size(), requests + 1);
  EXPECT_EQ(client_.options({"remainingPictures"}), Json::object());
  // The headers that the API requires.
  const httplib::Headers headers = camera_.headers();
  EXPECT_EQ(headers.find("X-XSRF-Protected")->second, "1");
  EXPECT_EQ(headers.find("Content-Type")->second, "application/json;charset=utf-8");
}

TEST_F(OscClientTest, AnEmptyAnswerIsAskedForAgainExceptOfATrigger) {
  int asked = 0;
  camera_.answers["camera.getOptions"] = [&](const Json& parameters) {
    return ++asked == 1 ? Json() : options_from({{"iso", 100}})(parameters);
  };
  answer("camera.takePicture", Json());
  EXPECT_EQ(client_.options({"iso"}), (Json{{"iso", 100}}));
  expect_fault(FaultKind::kNoContact, "/osc/commands/execute: the camera answers with nothing",
               [&] { client_.begin_picture(); });
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
    return Json{{"name", "camera.setOptions"}, {"state", "done"}};
  };
  // As Insta360 documents it; Ricoh's answers have less in them.
  camera_.answers["camera.takePicture"] = [&](const Json&) {
    if (set.back() != Json{{"captureMode", "image"}}) {
      return ScriptedCamera::error("disabledCommand", "in standby");
    }
    return Json{{"name", "camera.takePicture"},
                {"state", "inProgress"},
                {"id", "001996"},
                {"progress", {{"completion", 0}}}};
  };
  int polls = 0;
  camera_.answers["status"] = [&](const Json& asked) {
    if (asked.at("id") != "001996") return ScriptedCamera::error("invalidParameterValue", "id");
    if (++polls == 1) {
      return Json{{"state", "inProgress"}, {"id", "001996"}, {"progress", {{"completion", 0.5}}}};
    }
    const std::string path = "/DCIM/Camera01/IMG_20260101_051113_00_042.jpg";
    return ScriptedCamera::done({{"_fileGroup", {"http://192.168.42.1:80" + path}},
                                 {"_localFileGroup", {path}},
                                 {"fileUrl", "http://192.168.42.1:80" + path}});
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
  const Shot shot = camera.shoot(clock_.now());
  ASSERT_EQ(shot.pictures.size(), 1U);
  EXPECT_EQ(shot.pictures[0].camera_name, "IMG_20260101_051113_00_042.jpg");
  EXPECT_THAT(set,
              ElementsAre(Json{{"photoStitching", "ondevice"}}, Json{{"captureMode", "image"}}));
}

TEST_F(OscClientTest, CameraOfLevel2NeedsNoSession) {
  camera_.answers["camera.getOptions"] = options_from({{"iso", 100}});
  client_.open_session();
  client_.options({"iso"});
  EXPECT_THAT(camera_.commands(), ElementsAre("camera.getOptions"));
}

// A Ricoh Theta S has both levels and starts with the first.
TEST_F(OscClientTest, CameraOfBothLevelsIsSwitchedToTheSecondOnce) {
  camera_.info["apiLevel"] = {1, 2};
  camera_.state["_apiVersion"] = 1;
  answer("camera.startSession",
         ScriptedCamera::done({{"sessionId", "SID_0001"}, {"timeout", 180}}));
  Json raised, asked;
  camera_.answers["camera.setOptions"] = [&](const Json& parameters) {
    raised = parameters;
    return Json{{"name", "camera.setOptions"}, {"state", "done"}};
  };
  camera_.answers["camera.getOptions"] = [&](const Json& parameters) {
    asked = parameters;
    return ScriptedCamera::done({{"options", {{"iso", 100}}}});
  };
  client_.open_session();
  client_.open_session();
  client_.options({"iso"});
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
  answer("camera.setOptions", ScriptedCamera::error("invalidParameterName", "clientVersion"));
  camera_.answers["camera.takePicture"] = [](const Json& parameters) {
    return Json{{"results", {{"fileUri", parameters.at("sessionId").get<std::string>() + ".JPG"}}}};
  };
  Json fetched;
  camera_.answers["camera.getImage"] = [&](const Json& parameters) {
    fetched = parameters;
    return Json{{"the", "picture"}};
  };
  client_.open_session();
  client_.open_session();
  const OscCommand command = client_.begin_picture();
  EXPECT_TRUE(command.done);
  EXPECT_EQ(command.file, "S2.JPG");
  EXPECT_EQ(client_.fetch("S2.JPG"), "{\"the\":\"picture\"}");
  EXPECT_EQ(fetched, (Json{{"fileUri", "S2.JPG"}}));
}

TEST_F(OscClientTest, CameraInUseByAnotherProgramIsBusy) {
  camera_.info.erase("apiLevel");
  answer("camera.startSession", ScriptedCamera::error("cameraInExclusiveUse", "In use."));
  expect_fault(FaultKind::kBusy, "cameraInExclusiveUse", [&] { client_.open_session(); });
}

// Insta360's errors may have no state.
TEST_F(OscClientTest, RefusalsCarryCodeAndMessage) {
  answer("camera.setOptions",
         {{"error", {{"code", "invalidParameterName"}, {"message", "unsupported\noption"}}}});
  EXPECT_EQ(refusal_of([&] {
              client_.set_options({{"iso", 100}});
            }),
            std::pair(std::string("invalidParameterName: unsupported option"), false));
  answer("camera.takePicture", ScriptedCamera::error("disabledCommand", "not in image mode"));
  EXPECT_TRUE(refusal_of([&] { client_.begin_picture(); }).second);
  answer("camera.takePicture", {{"state", "error"}, {"error", "unknown"}});
  EXPECT_EQ(refusal_of([&] { client_.begin_picture(); }), std::pair(std::string(": "), false));
}

TEST_F(OscClientTest, IncompleteRepliesAreAWrongDevice) {
  for (const auto& [reply, words] :
       {std::pair{Json{{"name", "camera.takePicture"}}, "neither done nor in progress"},
        {Json{{"state", "inProgress"}}, "without an id"},
        {Json{{"state", 7}}, "neither done nor in progress"},
        {Json::object(), "neither done nor in progress"}}) {
    answer("camera.takePicture", reply);
    expect_fault(FaultKind::kWrongDevice, words, [&] { client_.begin_picture(); });
  }
  camera_.state = "fine";
  EXPECT_THROW(client_.state(), DeviceFault);
}

// With members missing, of other types, or unknown.
TEST_F(OscClientTest, ResultsNameAFileOrNone) {
  for (const auto& [results, file] :
       {std::pair{Json::object(), ""},
        {Json("done"), ""},
        {Json{{"fileUrl", ""}}, ""},
        {Json{{"fileUrl", nullptr}}, ""},
        {Json{{"_fileUri", "100RICOH/R1.JPG"}}, "100RICOH/R1.JPG"},
        {Json{{"fileUrl", "http://a/b.JPG"}, {"_dngFileUrls", {1}}}, "http://a/b.JPG"}}) {
    answer("camera.takePicture", ScriptedCamera::done(results));
    EXPECT_EQ(client_.begin_picture().file, file) << results;
  }
  answer("camera.takePicture", {{"state", "inProgress"}, {"id", 2792}});
  EXPECT_EQ(client_.begin_picture().id, "2792");
}

}  // namespace
}  // namespace raywalk::capture
