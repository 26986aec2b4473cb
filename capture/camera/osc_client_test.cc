#include "capture/camera/osc_client.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <httplib.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
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
using Json = nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::Property;
using testing::Throws;

// --- HTTP ----------------------------------------------------------------------------------------

// What a TCP server sends: `head`, and then `part` again and again where there is an interval.
struct Script {
  std::string head;
  std::string part{};
  std::optional<milliseconds> interval{};
  int signal = 0;  // raised before
};

class RawServer {
 public:
  explicit RawServer(Script script)
      : script_(std::move(script)), socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    if (bind(socket_, any, size) != 0 || listen(socket_, 8) != 0 ||
        getsockname(socket_, any, &size) != 0) {
      throw std::runtime_error("no loopback");
    }
    config.url = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    config.connect_timeout_ms = 200.0;
    config.picture_timeout_ms = 500.0;
    thread_ = std::jthread([this](const std::stop_token& token) { serve(token); });
  }
  ~RawServer() {
    thread_ = {};
    close(socket_);
  }
  RawServer(const RawServer&) = delete;
  RawServer& operator=(const RawServer&) = delete;

  OscConfig config{};

 private:
  void serve(const std::stop_token& token) {
    const auto is_readable = [](int socket) {
      pollfd entry{socket, POLLIN, 0};
      return poll(&entry, 1, 10) > 0;
    };
    while (!token.stop_requested()) {
      if (!is_readable(socket_)) continue;
      const int client = accept(socket_, nullptr, nullptr);
      while (!token.stop_requested() && !is_readable(client)) {
      }
      std::array<char, 4096> request{};
      if (recv(client, request.data(), request.size(), 0) > 0) {
        if (script_.signal != 0) std::raise(script_.signal);
        bool sent = send_text(client, script_.head);
        while (script_.interval && sent && !token.stop_requested()) {
          sent = send_text(client, script_.part);
          std::this_thread::sleep_for(*script_.interval);
        }
      }
      close(client);
    }
  }
  static bool send_text(int socket, const std::string& text) {
    return send(socket, text.data(), text.size(), MSG_NOSIGNAL) >= 0;
  }

  Script script_;
  int socket_;
  std::jthread thread_;
};

Script http(const std::string& status, const std::string& body) {
  return {"HTTP/1.1 " + status + "\r\nContent-Length: " + std::to_string(body.size()) +
          "\r\nConnection: close\r\n\r\n" + body};
}

TEST(OscHttp, ServersThatAreNoCameraAreNamed) {
  struct Case {
    FaultKind kind;
    std::string words;
    Script script;
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
           {kNone, "no complete reply", {""}},
           {kNone, "no complete reply", {"\x01\x02\x03 garbage\r\n\r\n"}},
           {kNone, "no complete reply", {ok + "Content-"}},
           {kNone, "no complete reply", {ok + "Content-Length: 100\r\n\r\n{\"model\": \"T\"}"}},
           {kWrong, "longer than", {ok + "\r\n", std::string(1 << 16, ' '), milliseconds(0)}},
           {kNone, "within 200 ms", {"", "", milliseconds(5)}},
           // Each byte arrives within the timeout of a read; the whole reply never ends.
           {kNone, "within 400 ms", {ok + "X: ", "y", milliseconds(20)}}}) {
    SCOPED_TRACE(each.words);
    RawServer server(each.script);
    ManualClock clock;
    OscClient client(server.config, clock);
    expect_fault(each.kind, server.config.url + "/osc/info: ", [&] { client.info(); });
    expect_fault(each.kind, each.words, [&] { client.info(); });
  }
}

TEST(OscHttp, PicturesAreFetchedWholeOrNotAtAll) {
  const auto fetched = [](const std::string& file, const Script& script) {
    RawServer server(script);
    ManualClock clock;
    return OscClient(server.config, clock).fetch(file);
  };
  // The address in the reply may differ from the configured one.
  for (const char* file : {"http://192.0.2.1:80/files/R0010001.JPG", "files/R0010001.JPG"}) {
    EXPECT_EQ(fetched(file, http("200 OK", "bytes")), "bytes");
  }
  expect_fault(FaultKind::kBadPicture, "/files/R0010001.JPG: HTTP 404",
               [&] { fetched("/files/R0010001.JPG", http("404 Not Found", "no")); });
  expect_fault(FaultKind::kNoContact, "no complete reply", [&] {
    fetched("/files/R0010001.JPG", {"HTTP/1.1 200 OK\r\nContent-Length: 1000\r\n\r\nonly"});
  });
}

// The interrupt flag is never cleared, so this runs in a separate process.
TEST(OscHttpDeathTest, InterruptEndsADownload) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto interrupted_download = [] {
    install_interrupt_handlers();
    RawServer server(
        {"HTTP/1.1 200 OK\r\nContent-Length: 100000000\r\n\r\n", "y", milliseconds(5), SIGTERM});
    ManualClock clock;
    server.config.picture_timeout_ms = 60000.0;
    EXPECT_THROW(OscClient(server.config, clock).fetch("/files/R0010001.JPG"), Interrupted);
    std::_Exit(testing::Test::HasFailure() ? 1 : 42);
  };
  EXPECT_EXIT(interrupted_download(), testing::ExitedWithCode(42), "");
}

// --- The API -------------------------------------------------------------------------------------

Json error(const std::string& code, const std::string& message) {
  return {{"state", "error"}, {"error", {{"code", code}, {"message", message}}}};
}
Json done(const Json& results) { return {{"state", "done"}, {"results", results}}; }

// A client and a camera with canned answers, which records commands and their parameters.
class OscClientTest : public testing::Test {
 protected:
  using Answer = std::function<Json(const Json& parameters)>;

  OscClientTest() {
    server_.Get("/osc/info", [this](const auto&, auto& response) { reply(info, &response); });
    server_.Post("/osc/state", [this](const auto&, auto& response) {
      reply({{"fingerprint", "1"}, {"state", state}}, &response);
    });
    server_.Post("/osc/commands/execute", [this](const auto& request, auto& response) {
      const Json command = Json::parse(request.body);
      const std::string name = command.at("name");
      const std::lock_guard lock(mutex_);
      commands_.push_back(name);
      asked_[name].push_back(command.value("parameters", Json::object()));
      headers_ = request.headers;
      const auto answer = answers.find(name);
      reply(answer == answers.end() ? error("unknownCommand", "No such command.")
                                    : answer->second(asked_[name].back()),
            &response);
    });
    server_.Post("/osc/commands/status", [this](const auto& request, auto& response) {
      reply(answers.at("status")(Json::parse(request.body)), &response);
    });
    server_.Get(".*\\.jpg", [this](const auto&, auto& response) {
      response.set_content(picture, "image/jpeg");
    });
    config.osc.url = "http://127.0.0.1:" + std::to_string(server_.bind_to_any_port("127.0.0.1"));
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    client_.emplace(config.osc, clock_);
  }
  ~OscClientTest() override {
    client_.reset();  // its connection, which the server would wait for
    while (!server_.is_running()) std::this_thread::yield();
    server_.stop();
    thread_.join();
  }

  void answer(const std::string& command, const Json& with) {
    answers[command] = [with](const Json&) { return with; };
  }
  // Holds a set of options and refuses requests with any other, as Ricoh and Insta360 do.
  void hold_options(const Json& known) {
    answers["camera.getOptions"] = [known](const Json& parameters) {
      Json options = Json::object();
      for (const std::string name : parameters.at("optionNames")) {
        if (!known.contains(name)) return error("invalidParameterName ", "is not supported.");
        options[name] = known.at(name);
      }
      return done({{"options", options}});
    };
  }
  std::vector<std::string> commands() const { return held(commands_); }
  std::vector<Json> asked(const std::string& command) const { return held(asked_).at(command); }
  std::string header(const std::string& name) const { return held(headers_).find(name)->second; }

  Json info = {{"model", "Scripted"}, {"apiLevel", {2}}};
  Json state = Json::object();
  std::string picture;                    // at any path that ends in .jpg
  std::map<std::string, Answer> answers;  // by the command; and "status"
  CameraConfig config;
  ManualClock clock_;
  std::optional<OscClient> client_;

  // Held while a command is answered.
  mutable std::mutex mutex_;
  std::map<std::string, std::vector<Json>> asked_;  // parameters, by the command

 private:
  template <typename Value>
  Value held(const Value& value) const {
    const std::lock_guard lock(mutex_);
    return value;
  }
  static void reply(const Json& json, httplib::Response* response) {
    if (json.contains("error")) response->status = 400;
    response->set_content(json.is_null() ? "" : json.dump(), "application/json");
  }

  httplib::Server server_;
  std::vector<std::string> commands_;
  httplib::Headers headers_;
  std::thread thread_;
};

TEST_F(OscClientTest, UnknownOptionsAreLeftOutAndNotRequestedAgain) {
  hold_options({{"iso", 100}, {"shutterSpeed", 0.5}});
  const Json expected = {{"iso", 100}, {"shutterSpeed", 0.5}};
  EXPECT_EQ(client_->options({"iso", "remainingPictures", "shutterSpeed"}), expected);
  const std::size_t requests = commands().size();
  EXPECT_EQ(client_->options({"iso", "remainingPictures", "shutterSpeed"}), expected);
  EXPECT_EQ(commands().size(), requests + 1);
  EXPECT_EQ(client_->options({"remainingPictures"}), Json::object());
  // The headers that the API requires.
  EXPECT_EQ(header("X-XSRF-Protected"), "1");
  EXPECT_EQ(header("Content-Type"), "application/json;charset=utf-8");
}

TEST_F(OscClientTest, AnEmptyAnswerIsAskedForAgainExceptOfATrigger) {
  bool is_first = true;
  answers["camera.getOptions"] = [&](const Json&) {
    return std::exchange(is_first, false) ? Json() : done({{"options", {{"iso", 100}}}});
  };
  answer("camera.takePicture", Json());
  EXPECT_EQ(client_->options({"iso"}), (Json{{"iso", 100}}));
  expect_fault(FaultKind::kNoContact, "/osc/commands/execute: the camera answers with nothing",
               [&] { client_->begin_picture(); });
  EXPECT_THAT(commands(),
              ElementsAre("camera.getOptions", "camera.getOptions", "camera.takePicture"));
}

// In standby, a Theta and an Insta360 refuse pictures until they are told their mode again.
TEST_F(OscClientTest, ACameraInStandbyIsWokenAndAskedForPanoramas) {
  hold_options({{"captureMode", "image"},
                {"photoStitching", "none"},
                {"photoStitchingSupport", {"none", "ondevice"}}});
  const Json wake = {{"options", {{"captureMode", "image"}}}};
  answer("camera.setOptions", {{"name", "camera.setOptions"}, {"state", "done"}});
  // As Insta360 documents it; Ricoh's answers have less in them.
  answers["camera.takePicture"] = [&](const Json&) {
    if (asked_["camera.setOptions"].back() != wake) {
      return error("disabledCommand", "in standby");
    }
    return Json{{"name", "camera.takePicture"},
                {"state", "inProgress"},
                {"id", "001996"},
                {"progress", {{"completion", 0}}}};
  };
  int polls = 0;
  answers["status"] = [&](const Json& of) {
    if (of.at("id") != "001996") return error("invalidParameterValue", "id");
    if (++polls == 1) {
      return Json{{"state", "inProgress"}, {"id", "001996"}, {"progress", {{"completion", 0.5}}}};
    }
    const std::string path = "/DCIM/Camera01/IMG_20260101_051113_00_042.jpg";
    return done({{"_fileGroup", {"http://192.168.42.1:80" + path}},
                 {"_localFileGroup", {path}},
                 {"fileUrl", "http://192.168.42.1:80" + path}});
  };
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", cv::Mat(32, 64, CV_8UC3, cv::Scalar::all(90)), bytes);
  picture.assign(bytes.begin(), bytes.end());
  OscCamera camera(config, clock_);
  camera.prepare({.lock = false}, "");
  const Shot shot = camera.shoot(clock_.now());
  ASSERT_EQ(shot.pictures.size(), 1U);
  EXPECT_EQ(shot.pictures[0].camera_name, "IMG_20260101_051113_00_042.jpg");
  EXPECT_THAT(asked("camera.setOptions"),
              ElementsAre(Json{{"options", {{"photoStitching", "ondevice"}}}}, wake));
}

TEST_F(OscClientTest, CameraOfLevel2NeedsNoSession) {
  hold_options({{"iso", 100}});
  client_->open_session();
  client_->options({"iso"});
  EXPECT_THAT(commands(), ElementsAre("camera.getOptions"));
}

// A Ricoh Theta S has both levels and starts with the first.
TEST_F(OscClientTest, CameraOfBothLevelsIsSwitchedToTheSecondOnce) {
  info["apiLevel"] = {1, 2};
  state["_apiVersion"] = 1;
  answer("camera.startSession", done({{"sessionId", "SID_0001"}, {"timeout", 180}}));
  answer("camera.setOptions", {{"name", "camera.setOptions"}, {"state", "done"}});
  hold_options({{"iso", 100}});
  client_->open_session();
  client_->open_session();
  client_->options({"iso"});
  EXPECT_THAT(commands(),
              ElementsAre("camera.startSession", "camera.setOptions", "camera.getOptions"));
  EXPECT_EQ(asked("camera.setOptions")[0],
            (Json{{"sessionId", "SID_0001"}, {"options", {{"clientVersion", 2}}}}));
  EXPECT_FALSE(asked("camera.getOptions")[0].contains("sessionId"));
}

TEST_F(OscClientTest, CameraOfLevel1IsUsedWithinASession) {
  info.erase("apiLevel");
  int sessions = 0;
  answers["camera.startSession"] = [&](const Json&) {
    return Json{{"results", {{"sessionId", "S" + std::to_string(++sessions)}, {"timeout", 60}}}};
  };
  answer("camera.setOptions", error("invalidParameterName", "clientVersion"));
  answers["camera.takePicture"] = [](const Json& parameters) {
    return Json{{"results", {{"fileUri", parameters.at("sessionId").get<std::string>() + ".JPG"}}}};
  };
  answer("camera.getImage", {{"the", "picture"}});
  client_->open_session();
  client_->open_session();
  const OscCommand command = client_->begin_picture();
  EXPECT_TRUE(command.done);
  EXPECT_EQ(command.file, "S2.JPG");
  EXPECT_EQ(client_->fetch("S2.JPG"), "{\"the\":\"picture\"}");
  EXPECT_EQ(asked("camera.getImage")[0], (Json{{"fileUri", "S2.JPG"}}));
}

TEST_F(OscClientTest, CameraInUseByAnotherProgramIsBusy) {
  info.erase("apiLevel");
  answer("camera.startSession", error("cameraInExclusiveUse", "In use."));
  expect_fault(FaultKind::kBusy, "cameraInExclusiveUse", [&] { client_->open_session(); });
}

TEST_F(OscClientTest, RefusalsCarryCodeAndMessage) {
  struct Case {
    Json reply;
    std::string said;
    bool is_temporary;
  };
  for (const Case& each : std::vector<Case>{
           // Insta360's errors may have no state.
           {{{"error", {{"code", "invalidParameterName"}, {"message", "unsupported\noption"}}}},
            " (invalidParameterName: unsupported option)",
            false},
           {error("disabledCommand", "not in image mode"), " (disabledCommand: not in image mode)",
            true},
           {{{"state", "error"}, {"error", "unknown"}}, " (: )", false}}) {
    answer("camera.takePicture", each.reply);
    EXPECT_THAT([&] { client_->begin_picture(); },
                Throws<OscRefusal>(AllOf(Property(&OscRefusal::in_parentheses, each.said),
                                         Property(&OscRefusal::is_temporary, each.is_temporary))));
  }
}

TEST_F(OscClientTest, IncompleteRepliesAreAWrongDevice) {
  for (const auto& [reply, words] :
       {std::pair{Json{{"name", "camera.takePicture"}}, "neither done nor in progress"},
        {Json{{"state", "inProgress"}}, "without an id"},
        {Json{{"state", 7}}, "neither done nor in progress"},
        {Json::object(), "neither done nor in progress"}}) {
    answer("camera.takePicture", reply);
    expect_fault(FaultKind::kWrongDevice, words, [&] { client_->begin_picture(); });
  }
  state = "fine";
  EXPECT_THROW(client_->state(), DeviceFault);
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
    answer("camera.takePicture", done(results));
    EXPECT_EQ(client_->begin_picture().file, file) << results;
  }
  answer("camera.takePicture", {{"state", "inProgress"}, {"id", 2792}});
  EXPECT_EQ(client_->begin_picture().id, "2792");
}

}  // namespace
}  // namespace raywalk::capture
